#pragma once

/// The part of a dialog that says what is going on, or what went wrong.

#include <QTextEdit>

namespace flatland_viz {

/// As high as its text, up to some lines; takes no room while it has nothing to say. The text can
/// be selected and copied.
class DialogMessage : public QTextEdit {
 public:
  DialogMessage();

  void Say(const QString& text);
  /// Says it in red.
  void Complain(const QString& text);

 protected:
  void resizeEvent(QResizeEvent* event) override;

 private:
  void Show(const QString& text, const QColor& color);
  void FitHeight();
};

}  // namespace flatland_viz
