"""XML that anybody may have written, read as a tree in bounded time and memory."""

from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from snowmpm.errors import InputError, shown_line
from snowmpm.reading.limited import read_limited

MAX_BYTES = 32 << 20
MAX_DEPTH = 100


def read_xml(path, namespaces=False):
    """Root of the file's tree. namespaces: tags and attributes are their local names, whatever namespace they have.

    Raises InputError for what cannot be read, is no XML, is too large or nested too deeply, and for a document type: no
    entity is ever expanded or fetched. OSError is left to the caller.
    """
    content = read_limited(path, MAX_BYTES)
    builder, depth = TreeBuilder(), 0
    parser = expat.ParserCreate(namespace_separator=" ") if namespaces else expat.ParserCreate()

    def start(tag, attributes):
        nonlocal depth
        depth += 1
        if depth > MAX_DEPTH:
            raise InputError(f"{path}: nested too deeply: at most {MAX_DEPTH} tags in each other")
        builder.start(_local(tag), {_local(name): value for name, value in attributes.items()})

    def end(tag):
        nonlocal depth
        depth -= 1
        builder.end(_local(tag))

    def doctype(*_):
        raise InputError(f"{path}: has a document type (<!DOCTYPE>), whose entities are not read")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = builder.data, doctype
    try:
        parser.Parse(content, True)
    except expat.ExpatError as error:
        raise InputError(f"{path}: not valid XML: {error}") from None
    except (LookupError, ValueError) as error:  # an encoding that Python does not have, or that takes several bytes
        raise InputError(f"{path}: its encoding cannot be read: {shown_line(error, 100)}; UTF-8 can") from None
    root: Element = builder.close()
    return root


def _local(name):
    return name.rpartition(" ")[2]
