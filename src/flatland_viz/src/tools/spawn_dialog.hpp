#pragma once

/// The dialog of the SpawnModel tool, for the file and the name.

#include <QDialog>

#include "model_choice.hpp"
#include "world_names.hpp"

class QCheckBox;
class QDialogButtonBox;
class QLineEdit;
class QSpinBox;

namespace flatland_viz {

class DialogMessage;

/// OK does not close the dialog: it emits Submitted, and the receiver closes the dialog or has it
/// show an error. The input is kept in either case.
class SpawnDialog : public QDialog {
  Q_OBJECT

 public:
  SpawnDialog(QWidget* parent, const ModelChoice& choice);

  ModelChoice choice() const;

  /// Proposes names that are free among these.
  void SetNames(const WorldNames& names);

  /// Enables input, and shows an error if there is one. `is_placed`: the model has its place
  /// already.
  void Open(const QString& error, bool is_placed);
  /// Disables all input but Cancel, and shows the reason.
  void Wait(const QString& reason);

  void accept() override;

 Q_SIGNALS:
  void Submitted(const flatland_viz::ModelChoice& choice);

 private:
  QWidget* MakeFileRow();
  QWidget* MakeNumberRow();
  void SelectFile();
  void Suggest();
  void WarnOfTwin();
  void SetInputEnabled(bool is_enabled);

  WorldNames names_;
  bool has_own_name_;
  bool has_own_namespace_;
  QLineEdit* file_;
  QLineEdit* name_;
  QLineEdit* namespace_;
  QCheckBox* is_numbered_;
  QSpinBox* number_;
  QWidget* inputs_;
  DialogMessage* message_;
  QDialogButtonBox* buttons_;
};

}  // namespace flatland_viz
