#pragma once

/// The model files that can be chosen from.

#include <QObject>
#include <QStringList>
#include <thread>

namespace flatland_viz {

class WorldModels;

/// Model files on this machine: those of models in the world, beside the world's file, in the
/// server's folders of models, and those spawned last.
class ModelFiles : public QObject {
  Q_OBJECT

 public:
  explicit ModelFiles(const WorldModels& models) : models_(models) {}
  ~ModelFiles() override;

  /// Puts a file that was spawned in front; it is remembered, also by other windows.
  void AddRecent(const QString& file);
  /// Looks into the folders again: asks the ROS master for them on a thread, and emits Found.
  void Look();
  /// All files, each once; those spawned last come first.
  QStringList files() const;

 Q_SIGNALS:
  void Found();

 private:
  void SetFolders(const QStringList& folders);

  const WorldModels& models_;
  QStringList in_folders_;
  std::thread thread_;
};

}  // namespace flatland_viz
