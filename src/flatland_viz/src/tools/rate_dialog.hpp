#pragma once

/// The dialog of the ChangeRate tool.

#include <flatland_msgs/SimulationState.h>

#include <QDialog>

class QComboBox;
class QLabel;

namespace flatland_viz {

class DialogMessage;

/// OK does not close the dialog: it emits Submitted, and the receiver closes the dialog or has it
/// show an error.
class RateDialog : public QDialog {
  Q_OBJECT

 public:
  explicit RateDialog(QWidget* parent);

  /// Shows the present rate, and the one that is reached.
  void ShowState(const flatland_msgs::SimulationState& state);
  void ShowError(const QString& error);

  void accept() override;

 Q_SIGNALS:
  void Submitted(double rate);

 private:
  bool has_rate_ = false;
  QComboBox* rate_;
  QLabel* state_;
  DialogMessage* message_;
};

}  // namespace flatland_viz
