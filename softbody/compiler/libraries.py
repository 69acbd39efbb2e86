"""What a kernel is made of: parts, which are LLVM's code, and the machine code of all of them together.

A part refers to other parts by name, and holds all else that it calls: so it is the same code in every process.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from typing import Any

import llvmlite.binding as llvm
from llvmlite.binding import Linkage
from numba.core.codegen import JITCodeLibrary
from numba.core.runtime import rtsys

from softbody.compiler.undisturbed import hear

# How names begin that Numba gives to its runtime, to environments, and to all functions.
RUNTIMES, ENVIRONMENTS, FUNCTIONS = "NRT_", "_ZN08NumbaEnv", "_ZN"


class PartLibrary(JITCodeLibrary):
    """What a kernel is to its callers: LLVM's code, which they link, optimise and make machine code of with their own.

    Numba would do all three for every kernel, and once more in every caller up the chain: two thirds of the time that
    the step of a world takes to compile.
    """

    is_whole = False  # it holds all that it calls, but for other parts
    is_lasting = False  # it holds nothing that is of this process alone
    callees: tuple[PartLibrary, ...] = ()
    seen_as: Any = None  # what callers depend on, if it has a name in every process

    def bitcode(self) -> bytes:
        """Return the code, to be kept."""
        return self._final_module.as_bitcode()  # type: ignore[no-any-return]

    def fill(self, bitcode: bytes, callees: Iterable[PartLibrary], reload: Iterable[Any]) -> None:
        """Become what was kept."""
        self._final_module = llvm.parse_bitcode(bitcode)
        self._reload_init.update(reload)
        self._finalized = self.is_lasting = True
        self._call(callees)

    @property
    def code(self) -> Any:
        """LLVM's code, without that of the libraries that are linked to it."""
        return self._final_module

    @property
    def linked(self) -> list[Any]:
        """The libraries that this one needs."""
        return self._linking_libraries

    def finalize(self) -> None:
        """End, without a link: what is called is linked once, to the kernel."""
        self._raise_if_finalized()
        hear()
        for library in self._linking_libraries:
            self._reload_init.update(library._reload_init)
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.external:
                function.linkage = Linkage.linkonce_odr  # what links this twice has it once
        self._finalize_dynamic_globals()
        self._finalized = True

    def make_whole(self, name: str, callees: Iterable[PartLibrary]) -> None:
        """Take in all that the function `name` calls, but for other parts, the `callees`.

        Numba numbers what it adds as it comes: in another process the same name may be another function's.
        """
        linked = callers_first(self._linking_libraries)
        added = [each for each in linked if not _is_apart(each)]
        _link(self._final_module, added)
        _let_nobody_use(self._final_module, {name})
        self.is_lasting = all(isinstance(each, PartLibrary) and not each.has_dynamic_globals for each in [self, *added])
        self._call([*callees, *(each for each in linked if isinstance(each, PartLibrary) and each.is_whole)])

    def _call(self, callees: Iterable[PartLibrary]) -> None:
        self.callees = tuple(dict.fromkeys(callees))
        self._linking_libraries = [*self.callees, rtsys.library]
        self.is_whole = True

    def _get_module_for_linking(self) -> Any:
        """Return all code that this part needs, for other Numba code, which does not know of parts."""
        module = self._final_module.clone()
        _link(module, callers_first(self.linked, through_parts=True))
        return module

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0: there is no machine code to point to."""
        return 0

    @property
    def codegen(self) -> Any:
        """Itself, which takes environments."""
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: only code in object mode looks at its environment."""


class KernelLibrary(JITCodeLibrary):
    """A kernel that Python calls, with all the parts that it calls, which nobody else will.

    As Numba links them, somebody might: then LLVM keeps their signatures, and each call pushes all fields of all arrays
    of its arguments, a hundred words and more. What is internal it gives the arguments that are read.
    """

    def finalize(self) -> None:
        """Link each part once, and make machine code of all."""
        self._own = {each.name for each in _defined_in(self._final_module)}
        linked = callers_first(self._linking_libraries, through_parts=True)
        _link(self._final_module, linked)
        for library in linked:
            self._reload_init.update(library._reload_init)
        self._linking_libraries = []
        for each in self._final_module.functions:
            if each.is_declaration and each.name.startswith(FUNCTIONS):  # its address would be 0
                raise RuntimeError(
                    f"a kernel calls {each.name[:80]}…, which is nowhere: delete the __pycache__ folders of softbody, "
                    "or set SOFTBODY_PLAIN_NUMBA=1"
                )
        super().finalize()

    def _optimize_final_module(self) -> None:
        _let_nobody_use(self._final_module, self._own)
        hear()
        super()._optimize_final_module()
        hear()


def callers_first(libraries: Iterable[Any], through_parts: bool = False) -> list[Any]:
    """Return libraries and what they call: LLVM leaves out what nobody has called so far.

    What a whole part calls counts if it goes `through_parts`.
    """
    seen, found = set(), []

    def add(library: Any) -> None:
        if library in seen:
            return
        seen.add(library)
        if isinstance(library, PartLibrary) and (through_parts or not library.is_whole):
            for callee in library.linked:
                add(callee)
        found.append(library)

    for library in libraries:
        add(library)
    return found[::-1]


def _link(module: Any, libraries: Iterable[Any]) -> None:
    """Add the code of libraries, callers first, to a module."""
    for library in libraries:
        code = library.code if isinstance(library, PartLibrary) else library._get_module_for_linking()
        module.link_in(code, preserve=True)


def _is_apart(library: Any) -> bool:
    """Tell whether a library is linked to kernels, not to parts."""
    return library is rtsys.library or (isinstance(library, PartLibrary) and library.is_whole)


def _let_nobody_use(module: Any, but: Collection[str]) -> None:
    """Let nobody else use what a module defines, `but` what is named.

    What is loaded later and called the same would be taken to be one of its functions. Numbers for names are the same
    in every process.
    """
    for number, each in enumerate(_defined_in(module)):
        if each.name not in but:
            each.linkage, each.name = Linkage.internal, f"{module.name}.{number}"


def _defined_in(module: Any) -> Iterator[Any]:
    """Yield the functions that a module has, and the places of their environments, which only object mode looks at."""
    for function in module.functions:
        if not (function.is_declaration or function.name.startswith(RUNTIMES)):
            yield function
    for variable in module.global_variables:
        if variable.name.startswith(ENVIRONMENTS):
            yield variable
