#pragma once

/// The palette of the SpawnModel tool: pictures of models, and the name of the next one.

#include <QDialog>
#include <QIcon>
#include <QMap>

#include "model_files.hpp"
#include "model_pictures.hpp"

class QDialogButtonBox;
class QLineEdit;
class QListWidget;
class QPlainTextEdit;

namespace flatland_viz {

class WorldModels;

/// A click on a picture chooses its model, Return or OK the one that is marked. The field above
/// them searches by name; it takes a path, too. OK does not close the dialog: it emits Submitted,
/// and the receiver closes the dialog or has it show an error. The input is kept in either case.
///
/// It proposes a free name, and a namespace for a model that would share topics with another.
class SpawnDialog : public QDialog {
  Q_OBJECT

 public:
  SpawnDialog(QWidget* parent, const WorldModels& models);

  /// The model that is marked, or the path in the field.
  QString file() const;
  QString name() const;
  /// Empty for none. A proposed one is for a copy, which gets a frame of odometry of its own by
  /// "~".
  QString ns() const;

  /// Enables input, and shows an error if there is one. `is_placed`: the model has its place
  /// already.
  void Open(const QString& error, bool is_placed);
  /// Disables all input but Cancel, and shows the reason.
  void Wait(const QString& reason);
  /// Puts the file in front, now that it was spawned; it is remembered.
  void Remember();

  void accept() override;

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 Q_SIGNALS:
  void Submitted();

 private:
  QWidget* MakeSearchRow();
  void ShowFiles();
  void Filter();
  void SetPicture(const QString& file, const QImage& picture);
  void SelectFile();
  void Suggest();
  void WarnOfTwin();
  void Say(const QString& message, bool is_error = false);
  void SetInputEnabled(bool is_enabled);

  const WorldModels& models_;
  ModelFiles files_;
  ModelPictures pictures_;
  QMap<QString, QIcon> icons_;  // by file
  bool has_own_name_ = false;
  bool has_own_namespace_ = false;
  QLineEdit* search_;  // or the path of a file
  QListWidget* list_;
  QLineEdit* name_;
  QLineEdit* namespace_;
  QWidget* inputs_;
  QPlainTextEdit* message_;
  QDialogButtonBox* buttons_;
};

}  // namespace flatland_viz
