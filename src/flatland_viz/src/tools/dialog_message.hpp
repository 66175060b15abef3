#pragma once

/// The part of a dialog that shows progress or an error.

#include <QTextEdit>

namespace flatland_viz {

/// As high as its text, up to ten lines; hidden while it has no text. The text can be selected and
/// copied.
class DialogMessage : public QTextEdit {
 public:
  DialogMessage();

  void ShowInfo(const QString& text);
  /// Shows it in red.
  void ShowError(const QString& text);

 protected:
  void resizeEvent(QResizeEvent* event) override;

 private:
  void Show(const QString& text, const QColor& color);
  void FitHeight();
};

}  // namespace flatland_viz
