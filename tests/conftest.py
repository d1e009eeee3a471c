"""For all tests: signatures are checked, compiled programs are remembered."""

import jaxtyping

# Before any module of the package is imported: beartype then checks every call's types and shapes.
jaxtyping.install_import_hook("jaxwalk", "beartype.beartype")

from jaxwalk import runtime  # noqa: E402

runtime.setup()
