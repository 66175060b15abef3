"""A dialog for files, no larger than the screen."""

from pathlib import Path

from python_qt_binding.QtWidgets import QDialog, QFileDialog, QWidget

from flatland_viz.window_size import on_screen


def ask_for_file(parent: QWidget, title: str, start: str, kinds: str, is_new: bool = False) -> str:
    """The file that the user chooses; empty if the dialog is cancelled.

    Args:
        parent: the window.
        title: the dialog's title.
        start: the folder, or the file, that it shows first; empty for the working directory.
        kinds: the files' kinds, such as "Worlds (*.yaml *.yml);;All files (*)".
        is_new: whether the file is to be written; otherwise there must be one. A name without a
            suffix gets that of `start`.
    """
    path = Path(start) if start else Path.cwd()
    folder = path.parent if is_new else path
    dialog = QFileDialog(parent, title, str(folder), kinds)
    if is_new:
        dialog.setAcceptMode(QFileDialog.AcceptSave)
        dialog.setFileMode(QFileDialog.AnyFile)
        dialog.setDefaultSuffix(path.suffix)  # to check for existing files
        dialog.selectFile(str(path))
    else:
        dialog.setFileMode(QFileDialog.ExistingFile)
    dialog.resize(on_screen(dialog.sizeHint().width(), dialog.sizeHint().height()))
    chosen = dialog.selectedFiles() if dialog.exec_() == QDialog.Accepted else []
    dialog.deleteLater()
    return str(chosen[0]) if chosen else ""
