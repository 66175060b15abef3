#include "dialog_message.hpp"

#include <QLayout>
#include <algorithm>
#include <cmath>

namespace flatland_viz {
namespace {

const QColor kErrorColor(198, 40, 40), kErrorColorOnDark(255, 128, 117);
constexpr int kMaxLines = 10;

}  // namespace

DialogMessage::DialogMessage() {
  setObjectName("message");
  setReadOnly(true);
  setFocusPolicy(Qt::ClickFocus);
  setFrameShape(QFrame::NoFrame);
  setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  viewport()->setAutoFillBackground(false);
  hide();
}

void DialogMessage::ShowInfo(const QString& text) {
  Show(text, window()->palette().color(QPalette::WindowText));
}

void DialogMessage::ShowError(const QString& text) {
  const bool is_dark = window()->palette().color(QPalette::Window).lightness() < 128;
  Show(text, is_dark ? kErrorColorOnDark : kErrorColor);
}

void DialogMessage::Show(const QString& text, const QColor& color) {
  QPalette colors = palette();
  colors.setColor(QPalette::Text, color);
  setPalette(colors);
  setPlainText(text);
  setVisible(!text.isEmpty());
  QLayout* layout = window()->layout();
  if (!layout) return;
  layout->activate();
  FitHeight();
  layout->activate();
  window()->resize(window()->width(), layout->sizeHint().height());
}

void DialogMessage::resizeEvent(QResizeEvent* event) {
  QTextEdit::resizeEvent(event);
  FitHeight();
}

void DialogMessage::FitHeight() {
  const int text_height = static_cast<int>(std::ceil(document()->size().height()));
  const int max_height = kMaxLines * fontMetrics().lineSpacing();
  setVerticalScrollBarPolicy(text_height > max_height ? Qt::ScrollBarAlwaysOn
                                                      : Qt::ScrollBarAlwaysOff);
  setFixedHeight(std::min(text_height, max_height));
}

}  // namespace flatland_viz
