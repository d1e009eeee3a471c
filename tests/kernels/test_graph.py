"""Arithmetic as a graph: what is known is computed at once, what is equal once."""

import numpy as np
import pytest

from jaxwalk.kernels.graph import Graph, Unsupported, known, reach

F32, BOOL = np.dtype(np.float32), np.dtype(bool)


@pytest.fixture
def graph() -> Graph:
    return Graph()


def test_the_same_operation_is_one_node_whatever_the_order_of_its_arguments(graph):
    a, b = graph.input(F32), graph.input(F32)
    assert a is not b
    assert graph.apply("add", (a, b), F32) is graph.apply("add", (b, a), F32)
    assert graph.apply("sub", (a, b), F32) is not graph.apply("sub", (b, a), F32)


def test_constants_are_computed_as_the_program_is_built(graph):
    six = graph.apply("mul", (np.float32(2), np.float32(3)), F32)
    assert known(six) and six.dtype == F32 and six == 6
    assert graph.apply("lt", (np.float32(2), np.float32(3)), BOOL)


@pytest.mark.parametrize(
    "op, other, expected",
    [("add", 0, "x"), ("sub", 0, "x"), ("mul", 1, "x"), ("div", 1, "x"), ("mul", 0, 0)],
)
def test_operations_that_change_nothing_are_not_done(graph, op, other, expected):
    x = graph.input(F32)
    result = graph.apply(op, (x, np.float32(other)), F32)
    assert result is x if expected == "x" else result == expected


def test_a_choice_that_is_known_is_made(graph):
    a, b, which = graph.input(F32), graph.input(F32), graph.input(BOOL)
    assert graph.apply("select", (np.bool_(True), a, b), F32) is b
    assert graph.apply("select", (np.bool_(False), a, b), F32) is a
    assert graph.apply("select", (which, a, a), F32) is a
    assert not known(graph.apply("select", (which, a, b), F32))


@pytest.mark.parametrize("op, neutral", [("and", True), ("or", False)])
def test_known_truth_values_decide_or_change_nothing(graph, op, neutral):
    x = graph.input(BOOL)
    for args in ((x, np.bool_(neutral)), (np.bool_(neutral), x)):
        assert graph.apply(op, args, BOOL) is x
    for args in ((x, np.bool_(not neutral)), (np.bool_(not neutral), x)):
        assert graph.apply(op, args, BOOL) == (not neutral)


def test_results_reach_what_they_need_and_nothing_else(graph):
    a, b = graph.input(F32), graph.input(F32)
    double, other = graph.apply("add", (a, a), F32), graph.apply("mul", (b, b), F32)
    result = graph.apply("sin", (double,), F32)
    assert reach([other, result, np.float32(1), a]) == [double, other, result]
    assert reach([result]) == [double, result]


def test_an_unknown_operation_is_refused_by_name(graph):
    with pytest.raises(Unsupported, match="lgamma"):
        graph.apply("lgamma", (graph.input(F32),), F32)
