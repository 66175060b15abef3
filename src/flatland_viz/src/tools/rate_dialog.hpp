#pragma once

/// Asks how fast the simulation is to run.

#include <flatland_msgs/SimulationState.h>

#include <QDialog>

class QComboBox;
class QLabel;

namespace flatland_viz {

class DialogMessage;

/// OK does not close the dialog: it emits Submitted, and whoever listens closes the dialog or lets
/// it show an error.
class RateDialog : public QDialog {
  Q_OBJECT

 public:
  explicit RateDialog(QWidget* parent);

  /// The present rate, and the one that is reached.
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
