#include "rate_dialog.hpp"

#include <QComboBox>
#include <QDialogButtonBox>
#include <QFormLayout>
#include <QLabel>
#include <QLineEdit>
#include <QVBoxLayout>

#include "dialog_message.hpp"
#include "rate.hpp"

namespace flatland_viz {

RateDialog::RateDialog(QWidget* parent)
    : QDialog(parent),
      rate_(new QComboBox),
      state_(new QLabel("unknown: no message from flatland_server")),
      message_(new DialogMessage) {
  setObjectName("change_rate_dialog");
  setWindowTitle("Change Rate");
  rate_->setObjectName("rate");
  rate_->setEditable(true);
  rate_->setCompleter(nullptr);  // it would complete "0" to "0.1"
  rate_->addItems(CommonRates());
  rate_->setCurrentText("1");
  rate_->lineEdit()->selectAll();
  rate_->setToolTip("Simulated seconds per second of real time.");
  state_->setObjectName("state");
  state_->setMinimumWidth(40 * fontMetrics().averageCharWidth());

  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel);
  connect(buttons, &QDialogButtonBox::accepted, this, &RateDialog::accept);
  connect(buttons, &QDialogButtonBox::rejected, this, &RateDialog::reject);
  auto* form = new QFormLayout;
  form->addRow("&Times real time:", rate_);
  form->addRow("Now:", state_);
  auto* layout = new QVBoxLayout(this);
  layout->addLayout(form);
  layout->addWidget(message_);
  layout->addWidget(buttons);
}

void RateDialog::ShowState(const flatland_msgs::SimulationState& state) {
  const QString reached =
      state.paused ? "paused" : QString("%1 is reached").arg(state.real_time_factor, 0, 'f', 2);
  state_->setText(QString("%1 (%2)").arg(FormatRate(state.rate), reached));
  if (has_rate_) return;
  has_rate_ = true;  // from now on only the user changes the field
  rate_->setCurrentText(FormatRate(state.rate));
  rate_->lineEdit()->selectAll();
}

void RateDialog::ShowError(const QString& error) {
  message_->ShowError(error);
  rate_->setFocus();
}

void RateDialog::accept() {
  if (const auto rate = ParseRate(rate_->currentText())) {
    Q_EMIT Submitted(*rate);
  } else {
    ShowError(QString("\"%1\" is not a number.").arg(rate_->currentText()));
  }
}

}  // namespace flatland_viz
