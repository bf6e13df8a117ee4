"""Visual SLAM where it must know a place: loops, a camera put elsewhere, sessions that meet."""

import pytest

from tests.end_to_end.slam import kidnappings, loops, sessions

pytestmark = pytest.mark.slow


def test_a_loop_by_one_camera_is_closed_and_its_unit_brought_back() -> None:
    (found,) = loops(0, ("one camera",))
    assert found.late is not None
    assert found.late <= 10
    assert 5.0 * found.closed_m <= found.open_m, found


def test_a_kidnapped_camera_is_found_or_begins_a_new_map_and_is_never_wrong() -> None:
    taken = list(kidnappings(0))
    assert len(taken) == 10
    assert not any(one.wrong for one in taken), taken
    assert all(one.frames is not None and one.frames <= 3 for one in taken), taken
    assert all(not one.new_map for one in taken if one.mapped), taken
    assert any(one.new_map for one in taken)


def test_one_camera_put_elsewhere_is_never_wrong() -> None:
    taken = list(kidnappings(0, "one camera", count=5))
    assert len(taken) == 5
    assert not any(one.wrong for one in taken), taken
    assert all(one.frames is not None for one in taken), taken
    assert all(not one.new_map for one in taken if one.mapped), taken


def test_a_second_session_that_begins_elsewhere_ends_in_the_map_of_the_first() -> None:
    found = sessions(0)
    assert found.connected
    assert found.posed >= found.frames - 2  # looked for in the first one's map before
    assert found.error_m < 0.05
