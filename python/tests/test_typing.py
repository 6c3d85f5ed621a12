"""The types of the package."""

from importlib import resources


def test_package_is_marked_as_typed() -> None:
    assert resources.files("inbye").joinpath("py.typed").is_file()
