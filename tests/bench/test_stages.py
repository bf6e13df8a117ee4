"""Where the time of work goes is told by thread and function, and adds up to what was spent."""

import threading
import time

from tests.bench.stages import NATIVE, profiled, stages_image, stages_table


def spin(seconds: float) -> None:
    """Keep a processor busy."""
    start = time.thread_time()
    while time.thread_time() - start < seconds:
        sum(range(1000))


def overlay() -> None:
    """Named as a stage is, so that its time counts as that stage's."""
    helper = threading.Thread(target=spin, args=(0.15,))
    helper.start()
    spin(0.3)
    helper.join()


def test_time_is_told_by_stage_thread_and_function() -> None:
    found = profiled(overlay)
    spent = {
        row["thread"]: row["processor_s"] for row in found["rows"] if "spin" in row["function"]
    }
    assert abs(spent["main"] - 0.3) < 0.1
    assert abs(spent["workers"] - 0.15) < 0.1
    assert found["clock_s"]["overlay"] >= 0.25
    total = sum(row["processor_s"] for row in found["rows"])
    assert 0.3 < total <= found["processor_s"]
    assert all(row["stage"] for row in found["rows"] if row["thread"] != NATIVE)


def test_stages_stand_in_the_table_and_in_the_image() -> None:
    rows = [
        {"stage": "overlay", "thread": "main", "function": "render/a.py: draw", "processor_s": 2.0},
        {"stage": "overlay", "thread": NATIVE, "function": "the rest", "processor_s": 1.0},
        {"stage": "report", "thread": "workers", "function": "b.py: write", "processor_s": 0.5},
    ]
    found = {"command": ["demo"], "seconds": 4.0, "processor_s": 3.5, "rows": rows}
    found["clock_s"] = {"overlay": 3.2, "report": 0.8}
    lines = stages_table(found).splitlines()
    assert lines[1].split() == ["overlay", "3.20", "3.00", "2.00", "0.00", "1.00"]
    assert lines[-2].split() == ["render/a.py:", "draw", "overlay", "main", "2.00"]
    assert lines[-1].split() == ["b.py:", "write", "report", "workers", "0.50"]
    image = stages_image(found)
    assert image.count("<rect") == 3 + 2 * 3
    assert ">overlay</text>" in image
