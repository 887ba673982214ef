"""The numbers of a law by name: one declaration for Python and for Taichi functions.

A law declares what its functions read as a NamedTuple:

    class ElasticParameters(NamedTuple):
        K: float  # bulk modulus [Pa]
        G: float  # shear modulus [Pa]

`Law.parameters` returns one of these, with numbers. A kernel keeps the numbers in a vector, and `named` makes of it
the same NamedTuple of the vector's entries. Taichi resolves `prm.K` while it compiles: the name costs nothing at run
time. A function takes `prm: ti.template()`; without the annotation Taichi would copy the tuple, and its names with it
would be lost.
"""

from snowmpm.compiler import ti


@ti.func
def named(names: ti.template(), numbers: ti.template()):
    """The entries of a vector by name. names: NamedTuple class of `Law.parameters`; the vector may be longer."""
    return ti.static(names(*[numbers[k] for k in range(len(names._fields))]))
