import pytest


@pytest.fixture
def faults(site_module, tmp_path):
    def check(html, css=""):
        (tmp_path / "index.html").write_text(html)
        (tmp_path / "other.html").write_text('<h1 id="here">x</h1>')
        (tmp_path / "site.css").write_text(css)
        return list(site_module("check").faults(tmp_path))

    return check


@pytest.mark.parametrize(
    "html",
    [
        '<script src="https://cdn.example/x.js"></script>',
        '<link rel="stylesheet" href="//fonts.example/a.css">',
        '<link rel="preconnect" href="https://fonts.example">',
        '<img src="http://example.org/a.png">',
        '<video poster="https://example.org/a.png"></video>',
        "<p style=\"background: url('https://example.org/a.png')\">",
    ],
)
def test_a_request_to_another_host_is_found(faults, html):
    assert len(faults(html)) == 1


def test_a_request_of_a_style_sheet_is_found(faults):
    assert len(faults("", "@import url(https://fonts.example/a.css);")) == 1


def test_links_to_nothing_are_found(faults):
    found = faults('<a href="none.html">a</a> <a href="other.html#there">b</a> <img src="none.png">')
    assert [line.split()[1:4] for line in found] == [
        ["loads", "none.png,", "which"],
        ["links", "to", "none.html,"],
        ["links", "to", "other.html#there;"],
    ]


def test_what_is_right_is_left_alone(faults):
    html = '<a href="https://gymnasium.farama.org">a</a><a href="other.html#here">b</a><a href="other.html#game=pong">c</a><link rel="next" href="other.html">'
    assert faults(html + '<link rel="stylesheet" href="site.css"><img src="data:image/png;base64,AA">') == []
