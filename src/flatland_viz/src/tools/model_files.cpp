#include "model_files.hpp"

#include <XmlRpcValue.h>
#include <ros/master.h>
#include <ros/this_node.h>

#include <QDir>
#include <QFileInfo>
#include <QMetaObject>
#include <QSettings>
#include <string>

#include "world_models.hpp"

namespace flatland_viz {
namespace {

constexpr int kMostRecent = 8;
const char* const kRecent = "recent_models";

/// The window's settings.
QSettings Settings() { return QSettings("flatland", "window"); }

/// A parameter as strings; none if it is not set, or without a master.
QStringList Parameter(const std::string& name) {
  XmlRpc::XmlRpcValue request, response, value;
  request[0] = ros::this_node::getName();
  request[1] = name;
  QStringList found;
  // ros::param::get would wait for a master that has ended.
  if (!ros::master::execute("getParam", request, response, value, false)) return found;
  if (value.getType() == XmlRpc::XmlRpcValue::TypeString) {
    found << QString::fromStdString(value);
  } else if (value.getType() == XmlRpc::XmlRpcValue::TypeArray) {
    for (int i = 0; i < value.size(); ++i) {
      if (value[i].getType() == XmlRpc::XmlRpcValue::TypeString) {
        found << QString::fromStdString(value[i]);
      }
    }
  }
  return found;
}

}  // namespace

ModelFiles::~ModelFiles() {
  if (thread_.joinable()) thread_.join();
}

void ModelFiles::AddRecent(const QString& file) {
  if (QFileInfo(file).isRelative()) return;  // the server knows what it is relative to
  QSettings settings = Settings();
  QStringList recent = settings.value(kRecent).toStringList();
  recent.removeAll(file);
  recent.prepend(file);
  settings.setValue(kRecent, QStringList(recent.mid(0, kMostRecent)));
}

void ModelFiles::Look() {
  if (thread_.joinable()) thread_.join();
  thread_ = std::thread([this] {
    QStringList folders;
    for (const QString& world : Parameter("/flatland_server/world_path")) {
      folders << QFileInfo(world).absolutePath();
    }
    for (const QString& list : Parameter("/flatland_server/models")) folders << list.split(':');
    QMetaObject::invokeMethod(
        this, [this, folders] { SetFolders(folders); }, Qt::QueuedConnection);
  });
}

void ModelFiles::SetFolders(const QStringList& folders) {
  in_folders_.clear();
  for (const QString& folder : folders) {
    if (folder.isEmpty()) continue;
    const auto entries = QDir(folder).entryInfoList({"*.model.yaml"}, QDir::Files, QDir::Name);
    for (const QFileInfo& file : entries) in_folders_ << file.canonicalFilePath();
  }
  Q_EMIT Found();
}

QStringList ModelFiles::files() const {
  QStringList all = Settings().value(kRecent).toStringList(), files;
  for (const auto& [name, model] : models_.models()) {
    all << QString::fromStdString(model.info.yaml_path);
  }
  for (const QString& file : all + in_folders_) {
    if (!files.contains(file) && QFileInfo(file).isFile()) files << file;
  }
  return files;
}

}  // namespace flatland_viz
