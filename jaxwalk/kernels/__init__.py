"""Small functions of one robot as code for many: C++ on vectors for a CPU, a few kernels for a GPU.

A GPU spends most of a small robot's tick on launching hundreds of small kernels, XLA's code for a CPU most of
it on memory. Here a function is unrolled into arithmetic on single numbers (`unroll` by `rules` and `randoms`
on `entries` of a `graph`) and cut into pieces that a compiler can digest (`pieces`). For a CPU these are
printed as C++ (`cpp`, `native`), compiled (`compiler`), kept (`store`) and called by XLA for many ticks at
once: `walk` is the way in. For a GPU each piece is a kernel with a robot to a thread (`pallas`, `emit`):
`fused` is.
"""
