"""The plant's tick as a few kernels for an accelerator, made from the very function that CPUs run.

A GPU spends most of a small robot's tick on launching hundreds of small kernels and on carrying their results
through its memory. Here a walker's tick (`stepper.tick`, or `walker.move` alone) is unrolled into arithmetic
on single numbers (`unroll` by `rules` on `entries` of a `graph`), cut into pieces that a compiler can digest
(`pieces`), and each piece becomes one kernel with a walker to a thread (`pallas`, `emit`). `fused` is the way
in.
"""
