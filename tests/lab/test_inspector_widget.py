"""`atari.lab.show`: the static picture, and the widget where anywidget is installed."""

import re
from typing import Any

import pytest

import atari
from atari.lab import show, widget
from atari.lab.inspector import protocol


def test_without_anywidget_it_is_a_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(widget, "_widget_class", lambda: None)
    env = atari.make("breakout")
    env.reset(seed=0)
    shown = show(env)
    html = shown._repr_html_()
    assert html.count("<td") == 128
    assert re.findall(r"<th[^>]*>([^<]*)</th>", html) == ["", *"0123456789ABCDEF", *(f"{row}0" for row in "89ABCDEF")]
    assert 'src="data:image/png;base64,' in html
    assert 'title="byte 57: lives"' in html
    assert "<script" not in html
    env.step(0)
    assert shown._repr_html_() != html


def test_export(monkeypatch: pytest.MonkeyPatch, tmp_path: object) -> None:
    monkeypatch.setattr(widget, "_widget_class", lambda: None)
    shown = show(atari.make("pong"))
    assert shown.export(str(tmp_path)) == []
    shown.inspection.freeze(50, 3)
    shown.inspection.step(10)
    assert [path.name for path in shown.export(str(tmp_path))] == ["pong-interventions.toml", "pong.a26r"]


def test_the_bundle_is_one_module() -> None:
    text = widget.bundle()
    assert not re.search(r"^\s*import\b", text, re.MULTILINE)
    assert re.findall(r"^export .*", text, re.MULTILINE) == ["export default { render };"]


def test_the_widget(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("anywidget")
    shown = show(atari.make("breakout"))
    sent: list[tuple[dict[str, object], object]] = []
    monkeypatch.setattr(shown, "send", lambda message, buffers=None: sent.append((message, buffers)))
    shown._receive(shown, {"do": "open"}, [])
    assert [next(iter(message)) for message, _ in sent] == ["hello", "frame", "objects", "state"]
    sent.clear()
    shown._receive(shown, {"do": "poke", "index": 57, "value": 3}, [])
    assert shown.inspection.ram()[57] == 3
    shown._receive(shown, {"do": "poke", "index": 57, "value": 300}, [])
    assert any("error" in message for message, _ in sent)


def test_the_widget_follows_its_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each in an output of its own: nbconvert shows no HTML of an output that has a widget, and no widget runs there."""
    pytest.importorskip("anywidget")
    outputs: list[Any] = []
    monkeypatch.setattr("IPython.display.display", lambda shown, raw=False: outputs.append(shown))
    shown = show(atari.make("breakout"))
    shown._ipython_display_()
    picture, view = outputs
    assert picture.data.count("<td") == 128
    assert "application/vnd.jupyter.widget-view+json" in view
    sent: list[dict[str, object]] = []
    monkeypatch.setattr(shown, "send", lambda message, buffers=None: sent.append(message))
    shown._receive(shown, {"do": "open"}, [])
    assert f'<div id="{sent[0]["picture"]}">' in picture.data


def test_the_widget_shows_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("anywidget")
    shown = show(atari.make("breakout"))
    sent: list[dict[str, object]] = []
    monkeypatch.setattr(shown, "send", lambda message, buffers=None: sent.append(message))
    with monkeypatch.context() as broken:
        broken.setattr(protocol, "frame", lambda inspection: {}["broken on purpose"])
        shown._receive(shown, {"do": "pause"}, [])
    assert {"error": "frame 0: KeyError('broken on purpose')"} in sent
    sent.clear()
    shown._receive(shown, {"do": "step", "frames": 3}, [])
    assert {"frame": 1} in sent
