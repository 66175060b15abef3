#include "model_choice.hpp"

#include <QByteArray>
#include <QFileInfo>

namespace flatland_viz {

QString NameFromFile(const QString& file) {
  QString name = QFileInfo(file).fileName();
  for (const char* ending : {".yaml", ".yml", ".model"}) {
    if (name.endsWith(ending)) name.chop(static_cast<int>(qstrlen(ending)));
  }
  return name;
}

QString ModelChoice::Name() const {
  const QString name = own_name.isEmpty() ? NameFromFile(file) : own_name;
  if (is_numbered) return QString("%1_%2").arg(name).arg(number);
  return own_name.isEmpty() && !proposed_name.isEmpty() ? proposed_name : name;
}

QString ModelChoice::Namespace() const {
  return own_ns.isEmpty() && !proposed_ns.isEmpty() ? "~" + proposed_ns : own_ns;
}

}  // namespace flatland_viz
