"""What native code computes is what JAX does; how walkers come in and go out."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as draw
from jax import lax

from jaxwalk.kernels import compiler, cpp, native, walk
from jaxwalk.kernels.graph import OPERATIONS, Unsupported
from jaxwalk.kernels.settings import jax_setting

EDGES = np.array(
    [0.0, -0.0, 1, -1, 0.5, -2.5, 3.5, np.inf, -np.inf, np.nan, 3e38, -3e38, 1e-30, 7e9, 8191.5],
    np.float32,
)
ROUND = partial(lax.round, rounding_method=lax.RoundingMethod.TO_NEAREST_EVEN)
EXACT = {
    "add": lax.add, "sub": lax.sub, "mul": lax.mul, "div": lax.div, "min": lax.min, "max": lax.max,
    "lt": lax.lt, "le": lax.le, "gt": lax.gt, "ge": lax.ge, "eq": lax.eq, "ne": lax.ne,
    "rem": lax.rem, "select": lambda x, y: jnp.where(x < y, x, y),
    "chosen": lambda x, y: jnp.where(x < 1, y < 1, x > 2),
    "neg": lambda x, _: -x, "abs": lambda x, _: jnp.abs(x), "sign": lambda x, _: jnp.sign(x),
    "floor": lambda x, _: jnp.floor(x), "round": lambda x, _: ROUND(x), "sqrt": lambda x, _: jnp.sqrt(x),
    "is_finite": lambda x, _: jnp.isfinite(x), "whole": lambda x, _: x.astype(jnp.int32),
    "unsigned": lambda x, _: x.astype(jnp.uint32), "truth": lambda x, _: x.astype(bool),
    "of_truth": lambda x, y: (x < y).astype(jnp.float32) + (x > y).astype(jnp.int32),
    "clipped": lambda x, _: jnp.clip(x, -1.5, 2.0), "least": lambda x, _: jnp.minimum(x, 1.0),
    "zeros": lambda x, y: jnp.where(x > y, -0.0, x),
    "angle": lambda x, _: jnp.arctan2(x, jnp.where(x > 9, x, -0.0)),
    "b_max": lambda x, y: jnp.maximum(x < y, x < 1), "b_min": lambda x, y: jnp.minimum(x < y, x < 1),
    "logic": lambda x, y: ((x < y) & ~(y < 0)) | ((x > 1) ^ (y > 1)) | ((x < 2) == (y < 2)),
}  # fmt: skip
NEAR = {
    "sin": lambda x, _: jnp.sin(x), "cos": lambda x, _: jnp.cos(x), "exp": lambda x, _: jnp.exp(x),
    "log1p": lambda x, _: jnp.log1p(x), "asin": lambda x, _: jnp.arcsin(x), "atan2": jnp.arctan2,
    "pow": lambda x, y: jnp.power(jnp.abs(x), y), "erf_inv": lambda x, _: lax.erf_inv(x),
}  # fmt: skip
WHOLE = {
    "i_add": lax.add, "i_mul": lax.mul, "i_min": lax.min, "i_max": lax.max, "i_lt": lax.lt, "i_ge": lax.ge,
    "i_div": lax.div, "i_rem": lax.rem, "i_and": lax.bitwise_and, "i_or": lax.bitwise_or,
    "i_xor": lax.bitwise_xor, "i_not": lambda a, _: ~a, "i_neg": lambda a, _: -a,
    "i_abs": lambda a, _: jnp.abs(a),
    "i_sign": lambda a, _: jnp.sign(a), "i_float": lambda a, _: a.astype(jnp.float32),
    "i_select": lambda a, b: jnp.where(a < b, a, b), "i_truth": lambda a, _: a.astype(bool),
    "u_float": lambda a, _: a.astype(jnp.uint32).astype(jnp.float32),
    "u_shifted": lambda a, _: (a.astype(jnp.uint32) << 13) | (a.astype(jnp.uint32) >> 19),
    "u_div": lambda a, b: lax.div(a.astype(jnp.uint32), b.astype(jnp.uint32)),
    "u_rem": lambda a, b: lax.rem(a.astype(jnp.uint32), b.astype(jnp.uint32)),
    "u_lt": lambda a, b: a.astype(jnp.uint32) < b.astype(jnp.uint32),
    "i_next": lambda a, _: a + 1 > a,
    "u_neg": lambda a, _: -a.astype(jnp.uint32), "u_sign": lambda a, _: jnp.sign(a.astype(jnp.uint32)),
    "u_bits": lambda a, _: lax.bitcast_convert_type(lax.bitcast_convert_type(a, jnp.float32), jnp.uint32),
}  # fmt: skip


def everything(_, state, x, y, a, b):
    """A row of all operations, by name."""
    floats = {name: function(x, y) for name, function in (EXACT | NEAR).items()}
    return state, floats | {name: function(a, b) for name, function in WHOLE.items()}


def by_native(x, y, a, b):
    many = jax.vmap(lambda *told: walk.scan(everything, None, 1, jnp.zeros(()), *told)[1])
    return jax.tree.map(lambda x: np.asarray(x)[:, 0], many(x, y, a, b))


@pytest.fixture(params=["native", 8, 4, 1])
def lanes(request, monkeypatch):
    """As many walkers a vector as this machine's vectors are long, and as on others."""
    if request.param != "native":
        if request.param == 8 and native.width() < 8:
            pytest.skip("this processor has no AVX2")
        monkeypatch.setattr(compiler, "FLAGS", (*compiler.FLAGS, f"-DW={request.param}"))
        yield request.param
    else:
        yield native.width()


def compared(x, y, a, b):
    found, expected = by_native(x, y, a, b), jax.jit(everything)(None, 0.0, x, y, a, b)[1]
    for name in EXACT | WHOLE:
        np.testing.assert_array_equal(found[name], expected[name], err_msg=name)
        if name == "zeros":
            np.testing.assert_array_equal(np.signbit(found[name]), np.signbit(expected[name]))
    for name in NEAR:
        np.testing.assert_allclose(found[name], expected[name], rtol=3e-6, atol=3e-7, err_msg=name)


def test_operations_are_jaxs_at_the_edges(lanes):
    x, y = (grid.ravel() for grid in np.meshgrid(EDGES, EDGES))
    # JAX, asked for the sine of what is very large, is a few units of the last place off itself.
    whole = np.array(
        [0, 1, -1, 7, -7, 13, 2**31 - 1, -(2**31), 12345, -54321, 3, 2, 16, 1 << 20, -2], np.int32
    )
    a, b = (grid.ravel() for grid in np.meshgrid(whole, whole))
    compared(x, y, a, b)


N = 64
floats = draw.arrays(
    np.float32, N, elements=st.floats(width=32, allow_subnormal=False, min_value=-1e6, max_value=1e6)
)
wholes = draw.arrays(np.int32, N, elements=st.integers(-(2**31), 2**31 - 1))


@settings(max_examples=60, deadline=None)
@given(floats, floats, wholes, wholes)
def test_operations_are_jaxs_wherever(x, y, a, b):
    compared(x, y, a, b)


def test_no_operation_lacks_a_test_or_a_name_in_cpp():
    assert OPERATIONS.keys() <= cpp.OPERATIONS
    tested = {name.removeprefix("i_") for name in EXACT | NEAR | WHOLE}
    assert OPERATIONS.keys() - tested <= {"shift_left", "shift_right_logical"}  # in u_shifted


def fibonacci(_, state, step):
    """Numbers that change places, that stay, a flag, a key, an array."""
    a, b, flag, key, table = state
    row = {"sum": a + b, "drawn": jax.random.normal(jax.random.fold_in(key, b), (3,)), "odd": flag}
    return (b, a + step * b, ~flag, key, table.at[1].add(a.astype(jnp.float32))), row


@pytest.mark.parametrize("walkers", [1, 15, 16, 17, 1000])
@pytest.mark.parametrize("length", [1, 2, 5])
def test_any_number_of_walkers_any_number_of_times(walkers, length):
    keys = jax.random.split(jax.random.key(1), walkers)
    count = jnp.arange(walkers)
    state = (count, count + 1, count % 2 == 0, keys, jnp.ones((walkers, 3)) * count[:, None])

    def every(scan):
        return jax.jit(jax.vmap(scan, in_axes=(0, None)))(state, 1)

    found, rows = every(lambda s, step: walk.scan(fibonacci, None, length, s, step))
    expected, wanted = every(
        lambda s, step: lax.scan(lambda s, _: fibonacci(None, s, step), s, length=length)
    )
    for ours, theirs in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        assert ours.dtype == theirs.dtype and bool(jnp.all(ours == theirs))
    drawn = (rows.pop("drawn"), wanted.pop("drawn"))
    np.testing.assert_allclose(*drawn, rtol=1e-6, atol=1e-6)
    jax.tree.map(np.testing.assert_array_equal, rows, wanted)


def test_seeds_and_walkers_are_mapped_over_at_once():
    x = jnp.arange(24.0).reshape(2, 4, 3)
    found = jax.jit(jax.vmap(jax.vmap(lambda x: walk.scan(doubled, None, 3, x)[0])))(x)
    np.testing.assert_array_equal(found, 8 * x)


def doubled(_, x):
    return 2 * x, None


def test_random_bits_are_jaxs_own():
    keys = jax.random.split(jax.random.key(7), 100)

    def ours(key):
        return walk.scan(bits, None, 1, key)[1][0]

    expected = jax.vmap(lambda key: bits(None, key)[1])(keys)
    np.testing.assert_array_equal(jax.vmap(ours)(keys), expected)


def bits(_, key):
    first, second = jax.random.split(jax.random.fold_in(key, 5))
    return key, jnp.concatenate([jax.random.bits(first, (7,)), jax.random.bits(second, (2,))])


def test_another_generator_than_threefry_is_refused_by_name():
    key = jax.random.key(0, impl="rbg")
    with pytest.raises(Unsupported, match="rbg"):
        walk.scan(bits, None, 1, key)


@pytest.mark.parametrize("dtype", [jnp.float16, jnp.int8, jnp.bfloat16])
def test_numbers_of_other_sizes_are_refused_by_name(dtype):
    with pytest.raises(Unsupported, match=np.dtype(dtype).name):
        walk.scan(doubled, None, 1, jnp.ones(3, dtype))


def test_a_function_is_known_by_more_than_its_name():
    """Two of one name: neither is taken for the other."""
    twice, thrice = (lambda _, x: (2 * x, None)), (lambda _, x: (3 * x, None))
    assert twice.__qualname__ == thrice.__qualname__
    assert [float(walk.scan(one, None, 1, jnp.ones(()))[0]) for one in (twice, thrice)] == [2, 3]


def test_what_was_kept_is_what_was_made(monkeypatch, tmp_path):
    """The second time, of a function of an installed package, nothing is unrolled."""
    before = jax_setting("jax_compilation_cache_dir")
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    try:
        x = jnp.arange(3.0)
        walk._program_of.cache_clear()
        monkeypatch.setattr(walk, "_origins", lambda _: "as of an installed package")
        first = walk.scan(doubled, None, 2, x)
        walk._program_of.cache_clear()
        monkeypatch.setattr(walk, "_unrolled", None)
        second = walk.scan(doubled, None, 2, x)
    finally:
        jax.config.update("jax_compilation_cache_dir", before)
        walk._program_of.cache_clear()
    np.testing.assert_array_equal(first[0], second[0])
    assert first[1] is None and second[1] is None


def test_a_state_that_changes_its_form_is_refused():
    with pytest.raises(Unsupported, match="form"):
        walk.scan(lambda _, x: (jnp.stack([x, x]), None), None, 1, jnp.zeros(()))


def test_a_loop_may_give_its_memory_up():
    """Under scan and with donated arguments, on all devices at once."""
    x = jnp.arange(64.0).reshape(32, 2)
    mesh = jax.make_mesh((jax.device_count(),), ("walkers",), axis_types=(jax.sharding.AxisType.Auto,))

    def far(x):
        return lax.scan(
            lambda x, _: (jax.vmap(lambda x: walk.scan(doubled, None, 2, x)[0])(x), None), x, length=3
        )[0]

    rows = jax.sharding.PartitionSpec("walkers")
    many = jax.jit(
        jax.shard_map(far, mesh=mesh, in_specs=rows, out_specs=rows, check_vma=False), donate_argnums=0
    )
    expected = np.asarray(x) * 64
    np.testing.assert_array_equal(many(jnp.copy(x)), expected)
