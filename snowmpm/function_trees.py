"""The Python side of compiling, which the kernels on disk spare nobody: trees of functions, read from a file once.

Taichi inlines a function at each of its calls, and reads, parses and goes through its source at each of them anew. Here
a tree is parsed once for a kernel and gone through as often as it is called, as Taichi itself goes through the body of
an unrolled loop; where a function begins and ends is found by parsing its file once, not by Python's `inspect`, which
looks through all modules and cuts the file into words.

Taichi uses all this once this module is imported.
"""

import ast
import functools
import linecache
import textwrap

from taichi.lang import kernel_impl
from taichi.lang.ast import ast_transformer_utils
from taichi.lang.ast.ast_transformer_utils import ASTTransformerContext

_trees = {}
"""By code object, of functions that the kernel now compiled has called and that are not being gone through."""


_transform_once = kernel_impl.transform_tree


def _transform(tree, context):
    result = _transform_once(tree, context)
    if context.is_kernel:
        _trees.clear()  # they hold all that was made of them
    else:
        _trees[context.func.func.__code__] = tree
    return result


def _tree_and_context(original, function, excluded_parameters=(), is_kernel=True, arg_features=None, args=None,
                      ast_builder=None, is_real_function=False):
    """Taichi's `_get_tree_and_ctx`. A function that is met while it is being gone through gets a tree of its own."""
    code = function.func.__code__
    tree = _trees.pop(code, None) or _parsed(code)
    if tree is None:
        return original(function, excluded_parameters, is_kernel, arg_features, args, ast_builder, is_real_function)
    global_vars = kernel_impl._get_global_vars(function.func)
    if is_kernel or is_real_function:
        for i in function.template_slot_locations:
            global_vars[function.arguments[i].name] = args[i]
    return tree, ASTTransformerContext(
        excluded_parameters=excluded_parameters, is_kernel=is_kernel, func=function, arg_features=arg_features,
        global_vars=global_vars, argument_data=args, file=code.co_filename, src=[""], start_lineno=code.co_firstlineno,
        ast_builder=ast_builder, is_real_function=is_real_function)


def _parsed(code):
    """Tree of a function, its lines counted from its first one, or None where the source is not in a file."""
    end = _ends(code.co_filename).get(code.co_firstlineno)
    if end is None:
        return None
    lines = linecache.getlines(code.co_filename)[code.co_firstlineno - 1 : end]
    tree = ast.parse(textwrap.dedent("".join(lines)))
    tree.body[0].decorator_list = []
    return tree


@functools.cache
def _ends(file):
    """Last line of each function of a file by its first one, decorators included."""
    try:
        pending = list(ast.parse("".join(linecache.getlines(file))).body)
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


kernel_impl._get_tree_and_ctx = functools.partial(_tree_and_context, kernel_impl._get_tree_and_ctx)
kernel_impl.transform_tree = _transform
ASTTransformerContext.get_pos_info = _place
ast_transformer_utils.Builder.__call__ = _visit(ast_transformer_utils.Builder.__call__)
