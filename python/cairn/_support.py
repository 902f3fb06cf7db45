"""What the compiled part of the package asks Python for."""

import json
import math
from typing import Any, Iterable, List, Mapping, NamedTuple, Sequence, Tuple

import numpy as np


class Session(NamedTuple):
    """A session of a map: the photos of one visit."""

    id: int
    name: str
    source: str
    recorded_at: str
    created_at: str
    num_images: int
    num_landmarks: int


class AnswerReport(NamedTuple):
    """What became of an answer that a FusionClient was given."""

    query_id: int
    outcome: str
    num_matches: int


class Rows(List[Tuple[Any, ...]]):
    """The rows of a result of SQL: tuples. `columns` has the names."""

    columns: Tuple[str, ...]

    def __init__(self, columns: Sequence[str], rows: Iterable[Tuple[Any, ...]]) -> None:
        super().__init__(rows)
        self.columns = tuple(columns)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(member) for key, member in value.items()}
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and math.isinf(value) and value > 0:
        return "infinity"
    return value


def options_as_json(options: Mapping[str, Any]) -> str:
    """A dict of options as the text of an options file."""
    return json.dumps(_plain(options), allow_nan=False)


def with_names(rows: Any, field: str, names: Sequence[str]) -> Any:
    """A structured array with a further field of text."""
    width = max((len(name) for name in names), default=1)
    dtype = [(name, *_shape_of(rows.dtype[name])) for name in rows.dtype.names]
    named = np.empty(len(rows), dtype=[*dtype, (field, f"U{max(width, 1)}")])
    for name in rows.dtype.names:
        named[name] = rows[name]
    named[field] = names
    return named


def _shape_of(dtype: Any) -> Tuple[Any, ...]:
    return (dtype.base, dtype.shape) if dtype.shape else (dtype,)
