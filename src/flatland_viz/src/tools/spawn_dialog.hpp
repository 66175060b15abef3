#pragma once

/// The palette of the SpawnModel tool: pictures of models, and the name of the next one.

#include <QDialog>
#include <QIcon>
#include <QMap>

#include "model_choice.hpp"
#include "model_pictures.hpp"
#include "world_names.hpp"

class QCheckBox;
class QDialogButtonBox;
class QLineEdit;
class QListWidget;
class QListWidgetItem;
class QSpinBox;

namespace flatland_viz {

class DialogMessage;
class ModelFiles;

/// A click on a picture chooses its model, Return or OK the one that is marked. The field above
/// them searches by name; it takes a path, too. OK does not close the dialog: it emits Submitted,
/// and the receiver closes the dialog or has it show an error. The input is kept in either case.
class SpawnDialog : public QDialog {
  Q_OBJECT

 public:
  /// `files`: those with pictures; outlives the dialog.
  SpawnDialog(QWidget* parent, const ModelChoice& choice, ModelFiles& files);

  ModelChoice choice() const;

  /// Proposes names that are free among these.
  void SetNames(const WorldNames& names);

  /// Enables input, and shows an error if there is one. `is_placed`: the model has its place
  /// already.
  void Open(const QString& error, bool is_placed);
  /// Disables all input but Cancel, and shows the reason.
  void Wait(const QString& reason);

  void accept() override;

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 Q_SIGNALS:
  void Submitted(const flatland_viz::ModelChoice& choice);

 private:
  QWidget* MakeSearchRow();
  void ShowFiles();
  void Filter();
  void SetPicture(const QString& file, const QImage& picture);
  QString File() const;
  QWidget* MakeNumberRow();
  void SelectFile();
  void Suggest();
  void WarnOfTwin();
  void SetInputEnabled(bool is_enabled);

  WorldNames names_;
  bool has_own_name_;
  bool has_own_namespace_;
  ModelFiles& files_;
  ModelPictures pictures_;
  QMap<QString, QIcon> icons_;  // by file
  QLineEdit* search_;           // or the path of a file
  QListWidget* list_;
  QLineEdit* name_;
  QLineEdit* namespace_;
  QCheckBox* is_numbered_;
  QSpinBox* number_;
  QWidget* inputs_;
  DialogMessage* message_;
  QDialogButtonBox* buttons_;
};

}  // namespace flatland_viz
