"""A short walk with :mod:`fuzz_calls`; a long one is run by hand."""

from fuzz_calls import fuzz


def test_three_thousand_random_calls_answer_or_raise_what_is_expected():
    told = fuzz(3000, seed=20)
    assert told["answered"] > 1000 and told["ValueError"] > 100 and told["TypeError"] > 100
