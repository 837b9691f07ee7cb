from html.parser import HTMLParser

import pytest
from matplotlib.figure import Figure

from sim1.report import Picture, Section, write_report


class Links(HTMLParser):
    """Collects every address that a page would load or point to."""

    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.tags: list[str] = []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.addresses += [value for name, value in attrs if name in {"src", "href", "srcset", "data"}]


@pytest.fixture
def picture(tmp_path):
    path = tmp_path / "plot.png"
    figure = Figure(figsize=(2, 1))
    figure.subplots().plot([1, 2])
    figure.savefig(path)
    return path


def test_page_needs_no_other_file_and_shows_what_it_was_given(tmp_path, picture):
    path = tmp_path / "report.html"
    rows = [{"stage": "scan", "error_mm": 0.123456, "done": True}, {"stage": "mesh", "error_mm": None, "of": ["a", 2]}]
    write_report(
        path,
        "Title <1>",
        "Lead & more",
        [Section(heading="First", paragraphs=["Text"], table=rows, pictures=[Picture(path=picture, caption="A plot")])],
    )
    page = path.read_text()
    links = Links()
    links.feed(page)
    assert len(links.addresses) == 1
    assert links.addresses[0].startswith("data:image/png;base64,")
    assert not {"script", "link", "iframe"} & set(links.tags)
    assert "url(" not in page
    assert "Title &lt;1&gt;" in page
    assert "Lead &amp; more" in page
    assert '<th class="number">error mm</th>' in page
    assert "0.1235" in page
    assert ">–</td>" in page
    assert ">a, 2</td>" in page


def test_columns_of_one_quantity_stand_under_one_heading(tmp_path):
    rows = [{"who": "a", "cost | here": 1, "cost | paper": 2, "pace": "slow"}]
    write_report(tmp_path / "r.html", "t", "l", [Section(heading="A", table=rows)])
    page = (tmp_path / "r.html").read_text()
    assert '<th rowspan="2">who</th><th colspan="2">cost</th><th rowspan="2">pace</th>' in page
    assert '<tr><th class="number">here</th><th class="number">paper</th></tr>' in page


def test_same_input_gives_the_same_bytes(tmp_path, picture):
    sections = [Section(heading="A", table=[{"x": 1}], pictures=[picture])]
    for name in ("one.html", "two.html"):
        write_report(tmp_path / name, "t", "l", sections)
    assert (tmp_path / "one.html").read_bytes() == (tmp_path / "two.html").read_bytes()


def test_a_picture_of_an_unknown_kind_is_refused(tmp_path):
    (tmp_path / "a.svg").write_text("<svg/>")
    with pytest.raises(ValueError, match=r"a\.svg"):
        write_report(tmp_path / "r.html", "t", "l", [Section(heading="A", pictures=[tmp_path / "a.svg"])])
