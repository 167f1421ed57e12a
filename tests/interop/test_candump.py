"""Text logs: every sound line is kept, every bad one counted where it stands."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.errors import InputError, MissingExtraError
from mcdas_opt.interop.recordings.candump import read_candump, write_candump
from mcdas_opt.interop.recordings.recording import Frame

frames = st.lists(
    st.builds(
        Frame,
        t_s=st.integers(0, 10_000_000).map(lambda us: us / 1e6),
        channel=st.sampled_from(["can0", "can1", "vcan0"]),
        identifier=st.one_of(st.integers(0, 0x7FF), st.integers(0x800, 0x1FFFFFFF)),
        data=st.binary(max_size=8),
    ),
    min_size=1,
    max_size=20,
)


def strip(frame: Frame) -> tuple[object, ...]:
    return (round(frame.t_s, 6), frame.channel, frame.identifier, frame.data)


@given(frames)
def test_what_is_written_is_read(tmp_path_factory: pytest.TempPathFactory, sent: list[Frame]) -> None:
    path = tmp_path_factory.mktemp("log") / "a.log"
    path.write_text(write_candump(sent))
    log = read_candump(path)
    assert [strip(frame) for frame in log.frames] == [strip(frame) for frame in sent]
    assert log.bad.total == 0
    assert write_candump(log.frames) == path.read_text()


@given(frames, st.integers(1, 40))
def test_a_log_cut_anywhere_keeps_the_whole_lines(tmp_path_factory: pytest.TempPathFactory, sent: list[Frame], cut: int) -> None:
    path = tmp_path_factory.mktemp("log") / "a.log"
    first = Frame(t_s=0.0, channel="can0", identifier=0x500, data=bytes(8))
    whole = write_candump([first, *sent])
    path.write_text(whole[: max(len(whole) - cut, len(first.to_line()) + 1)])
    log = read_candump(path)
    complete = path.read_text().count("\n")
    assert len(log.frames) + log.bad.total in (complete, complete + 1)
    assert [strip(f) for f in log.frames[:complete]] == [strip(f) for f in [first, *sent]][: len(log.frames[:complete])]
    assert len(log.frames) >= complete


@pytest.mark.parametrize(
    ("line", "kind"),
    [
        ("(15.300000) can0 500#006091F01000022", "cut short"),
        ("(15.300000) can0 500", "cut short"),
        ("(15.3", "cut short"),
        ("(15.300000) can0 500##", "cut short"),
        ("(15.300000) can0 500##1AAB", "cut short"),
        ("(15.300000) can0 500##A00", "not a candump line"),
        ("garbage", "not a candump line"),
        ("(15.300000) can0 500#0060ZZF010000227", "not a candump line"),
        ("(15.300000) can0 500#006091F010000227FF", "not a candump line"),
        ("(nan) can0 500#006091F010000227", "not a candump line"),
        ("(-1.0) can0 500#006091F010000227", "not a candump line"),
        ("\x00\x00\ufffd", "not a candump line"),
        ("(999999.0) can0 500#006091F010000227", "stamp far from its neighbours"),
    ],
)
def test_a_bad_line_is_counted_with_its_number(tmp_path: Path, line: str, kind: str) -> None:
    path = tmp_path / "a.log"
    good = "(15.{}00000) can0 500#006079E210000251"
    path.write_text("\n".join([good.format(0), good.format(1), line, good.format(2), good.format(3)]) + "\n")
    log = read_candump(path)
    assert log.bad.to_document() == {kind: {"count": 1, "first_line": 3}}
    assert [frame.line for frame in log.frames] == [1, 2, 4, 5]


def test_bytes_that_are_no_text_are_bad_lines(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    path.write_bytes(b"(0.0) can0 500#00\n\xff\xfe\x00\n(0.1) can0 500#01\r\n")
    log = read_candump(path)
    assert ([f.data for f in log.frames], log.bad.total) == ([b"\x00", b"\x01"], 1)


def test_lines_that_hold_no_data_frame_are_other(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    path.write_text("(0.0) can0 500#R\n(0.1) can0 500##1AABB\n(0.2) can0 20000080#0000000000000000\n(0.3) can0 500#01 R\n")
    log = read_candump(path)
    assert (len(log.frames), log.other, log.bad.total) == (1, 3, 0)


@pytest.mark.parametrize("text", ["", "\n\n", "time,x,y\n0,1,2\n", "can0  500   [8]  00 60 79 E2 10 00 02 51\n"])
def test_a_file_of_another_kind_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.log"
    path.write_text(text)
    with pytest.raises(InputError, match=r"a\.log: line 1.*candump"):
        read_candump(path)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    for path in (tmp_path / "none.log", tmp_path):
        with pytest.raises(InputError, match="cannot be read"):
            read_candump(path)


def test_without_python_can_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.log"
    path.write_text("(0.0) can0 500#00\n")
    monkeypatch.setitem(sys.modules, "can", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'mcdas-opt\[can\]'"):
        read_candump(path)
