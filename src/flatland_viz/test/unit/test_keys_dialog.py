"""The page with the window's keys."""

from flatland_viz.keys_dialog import page


def test_tables_without_rows_are_left_out():
    text = page([[("World", [("F5", "Reload <files>")]), ("Help", [])]])

    assert "World" in text
    assert "F5" in text
    assert "Reload &lt;files&gt;" in text
    assert "Help" not in text
