"""The Python side of compiling, which the kernels on disk spare nobody: trees of functions, read from a file once.

Taichi inlines a function at each of its calls, and reads, parses and goes through its source at each of them anew. Here
a tree is parsed once for a kernel and gone through as often as it is called, as Taichi itself goes through the body of
an unrolled loop; where a function begins and ends is found by parsing its file once, not by Python's `inspect`, which
looks through all modules and cuts the file into words.

Taichi uses all this once this module is imported, unless the patch is switched off (`snowmpm.compiler.patches`).
"""

import ast
import functools
import linecache
import textwrap

from snowmpm.compiler import patches
from snowmpm.compiler.backend import part

_trees = {}
"""By code object, of functions that the kernel now compiled has called and that are not being gone through."""

_read = {}
"""By file: its lines, which `linecache` reads anew where the file has changed, and the ends of its functions."""


def _transform(original, tree, context):
    result = original(tree, context)
    if context.is_kernel:
        _trees.clear()  # they hold all that was made of them
    else:
        _trees[context.func.func.__code__] = tree
    return result


def _tree_and_context(taichi, original, function, excluded_parameters=(), is_kernel=True, arg_features=None, args=None,
                      ast_builder=None, is_real_function=False):
    """Taichi's `_get_tree_and_ctx`; taichi: its module `kernel_impl`.

    A function that is met while it is being gone through gets a tree of its own.
    """
    code = function.func.__code__
    tree = _trees.pop(code, None) or _parsed(code)
    if tree is None:
        return original(function, excluded_parameters, is_kernel, arg_features, args, ast_builder, is_real_function)
    global_vars = taichi._get_global_vars(function.func)
    if is_kernel or is_real_function:
        for i in function.template_slot_locations:
            global_vars[function.arguments[i].name] = args[i]
    return tree, taichi.ASTTransformerContext(
        excluded_parameters=excluded_parameters, is_kernel=is_kernel, func=function, arg_features=arg_features,
        global_vars=global_vars, argument_data=args, file=code.co_filename, src=[""], start_lineno=code.co_firstlineno,
        ast_builder=ast_builder, is_real_function=is_real_function)


def _parsed(code):
    """Tree of a function, its lines counted from its first one, or None where the source is not in a file."""
    text = _text(code)
    if text is None:
        return None
    tree = ast.parse(text)
    tree.body[0].decorator_list = []
    return tree


def _text(code):
    linecache.checkcache(code.co_filename)  # a file that was edited and imported again
    end = _ends(code.co_filename).get(code.co_firstlineno)
    if end is None:
        return None
    return textwrap.dedent("".join(linecache.getlines(code.co_filename)[code.co_firstlineno - 1 : end]))


def source_of(code):
    """-> lines of a function, without indentation, and the number of the first one of its body. OSError where its
    source is not in a file."""
    text = _text(code)
    if text is None:
        raise OSError(f"no source of {code.co_name} in {code.co_filename}")
    return text.splitlines(), ast.parse(text).body[0].body[0].lineno - 1


def _ends(file):
    """Last line of each function of a file by its first one, decorators included."""
    lines = linecache.getlines(file)
    if file not in _read or _read[file][0] is not lines:
        _read[file] = lines, _last_lines(lines)
    return _read[file][1]


def _last_lines(lines):
    try:
        pending = list(ast.parse("".join(lines)).body)
    except SyntaxError:
        return {}
    ends = {}
    while pending:
        node = pending.pop()
        if isinstance(node, ast.FunctionDef):
            ends[min([node.lineno] + [decorator.lineno for decorator in node.decorator_list])] = node.end_lineno
        for name in ("body", "orelse", "handlers", "finalbody"):
            pending.extend(getattr(node, name, ()))
    return ends


def _place(context, node):
    """File, line and function of a statement, without the picture of its source that Taichi draws of every node."""
    return f'File "{context.file}", line {node.lineno + context.lineno_offset}, in {context.func.func.__name__}\n'


def _visit(original):
    """Taichi's visitor, which says where it is at every node; this one does at every statement."""
    methods = {}

    def visit(builder, context, node):
        kind = node.__class__
        if kind not in methods:
            name = "build_" + kind.__name__
            methods[kind] = name if issubclass(kind, ast.expr) and hasattr(builder, name) else None
        name = methods[kind]
        return original(builder, context, node) if name is None else getattr(builder, name)(context, node)

    return visit


def _install():
    kernel_impl, ast_transformer_utils = part("lang.kernel_impl"), part("lang.ast.ast_transformer_utils")

    context, builder = kernel_impl.ASTTransformerContext, ast_transformer_utils.Builder
    read, transform, visit = kernel_impl._get_tree_and_ctx, kernel_impl.transform_tree, builder.__call__
    kernel_impl._get_global_vars  # noqa: B018 (used later: it must be there)
    replace = functools.partial(patches.replace, "function_trees")
    replace(kernel_impl, "_get_tree_and_ctx", functools.partial(_tree_and_context, kernel_impl, read))
    replace(kernel_impl, "transform_tree", functools.partial(_transform, transform))
    replace(context, "get_pos_info", _place)
    replace(builder, "__call__", _visit(visit))


patches.apply("function_trees", _install)
