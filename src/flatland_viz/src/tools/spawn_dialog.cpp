#include "spawn_dialog.hpp"

#include <QCheckBox>
#include <QDialogButtonBox>
#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QSpinBox>
#include <QVBoxLayout>
#include <limits>

#include "dialog_message.hpp"

namespace flatland_viz {

SpawnDialog::SpawnDialog(QWidget* parent, const ModelChoice& choice)
    : QDialog(parent),
      has_own_name_(!choice.own_name.isEmpty()),
      has_own_namespace_(!choice.own_ns.isEmpty()),
      file_(new QLineEdit(choice.file)),
      name_(new QLineEdit(choice.own_name)),
      namespace_(new QLineEdit(choice.own_ns)),
      is_numbered_(new QCheckBox("Append a n&umber:")),
      number_(new QSpinBox),
      inputs_(new QWidget),
      message_(new DialogMessage),
      buttons_(new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel)) {
  setObjectName("spawn_model_dialog");
  setWindowTitle("Spawn Model");
  file_->setMinimumWidth(40 * fontMetrics().averageCharWidth());
  name_->setObjectName("name");
  namespace_->setObjectName("namespace");
  namespace_->setPlaceholderText("none");
  is_numbered_->setChecked(choice.is_numbered);
  number_->setMaximum(std::numeric_limits<int>::max());
  number_->setValue(choice.number);

  auto* form = new QFormLayout(inputs_);
  form->setContentsMargins(0, 0, 0, 0);
  auto* file_label = new QLabel("Model &file:");
  file_label->setBuddy(file_);
  form->addRow(file_label, MakeFileRow());
  form->addRow("&Name:", name_);
  form->addRow("", MakeNumberRow());
  form->addRow("Name&space:", namespace_);
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(inputs_);
  layout->addWidget(message_);
  layout->addWidget(buttons_);

  Suggest();
  connect(file_, &QLineEdit::textChanged, this, &SpawnDialog::Suggest);
  connect(is_numbered_, &QCheckBox::toggled, this, &SpawnDialog::Suggest);
  connect(number_, QOverload<int>::of(&QSpinBox::valueChanged), this, &SpawnDialog::Suggest);
  connect(name_, &QLineEdit::textEdited, this, [this](const QString& name) {
    has_own_name_ = !name.isEmpty();
    Suggest();
  });
  connect(namespace_, &QLineEdit::textEdited, this, [this] {
    has_own_namespace_ = true;  // also if it is empty
    WarnOfTwin();
  });
  buttons_->button(QDialogButtonBox::Cancel)->setAutoDefault(false);
  connect(buttons_, &QDialogButtonBox::accepted, this, &SpawnDialog::accept);
  connect(buttons_, &QDialogButtonBox::rejected, this, &SpawnDialog::reject);
}

QWidget* SpawnDialog::MakeFileRow() {
  file_->setObjectName("file");
  auto* select = new QPushButton("Se&lect...");
  select->setObjectName("select_file");
  select->setAutoDefault(false);
  connect(select, &QPushButton::clicked, this, &SpawnDialog::SelectFile);

  auto* row = new QWidget;
  auto* layout = new QHBoxLayout(row);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(file_);
  layout->addWidget(select);
  return row;
}

QWidget* SpawnDialog::MakeNumberRow() {
  is_numbered_->setObjectName("is_numbered");
  is_numbered_->setToolTip("Append a number to the name, one more for each model.");
  number_->setObjectName("number");
  number_->setEnabled(is_numbered_->isChecked());
  connect(is_numbered_, &QCheckBox::toggled, number_, &QWidget::setEnabled);

  auto* row = new QWidget;
  auto* layout = new QHBoxLayout(row);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(is_numbered_);
  layout->addWidget(number_);
  layout->addStretch();
  return row;
}

void SpawnDialog::SelectFile() {
  const QFileInfo present(file_->text());
  const bool has_folder = !file_->text().isEmpty() && present.dir().exists();
  auto* chooser = new QFileDialog(this, "Select model file",
                                  has_folder ? present.absolutePath() : QDir::homePath(),
                                  "Models (*.yaml *.yml);;All files (*)");
  chooser->setObjectName("select_file_dialog");
  chooser->setAttribute(Qt::WA_DeleteOnClose);
  chooser->setFileMode(QFileDialog::ExistingFile);
  chooser->setOption(
      QFileDialog::DontUseNativeDialog);  // the same everywhere, and without a portal
  if (present.isFile()) chooser->selectFile(present.fileName());
  connect(chooser, &QFileDialog::fileSelected, file_, &QLineEdit::setText);
  connect(chooser, &QDialog::finished, this, [this] {
    activateWindow();
    name_->setFocus();
    name_->selectAll();
  });
  chooser->open();
  chooser->activateWindow();
}

void SpawnDialog::SetNames(const WorldNames& names) {
  names_ = names;
  if (inputs_->isEnabled()) Suggest();
}

void SpawnDialog::Suggest() {
  if (!has_own_name_ && !name_->hasFocus()) {
    const QString name = NameFromFile(file_->text());
    name_->setText(is_numbered_->isChecked() ? name : names_.FreeName(name));
  }
  if (!has_own_namespace_) {
    const QString file = file_->text().trimmed();
    namespace_->setText(names_.FindTwin(file, {}) ? choice().Name() : QString());
  }
  WarnOfTwin();
}

void SpawnDialog::WarnOfTwin() {
  const flatland_msgs::ModelInfo* twin =
      names_.FindTwin(file_->text().trimmed(), namespace_->text().trimmed());
  if (!twin) {
    message_->ShowInfo({});
    return;
  }
  const QString name = QString::fromStdString(twin->name), commands = CommandTopic(*twin);
  message_->ShowInfo(commands.isEmpty()
                         ? QString("%1 has the same topics. Give this one a namespace.").arg(name)
                         : QString("%1 listens to %2, too: one command would drive both. Give this "
                                   "one a namespace.")
                               .arg(name, commands));
}

ModelChoice SpawnDialog::choice() const {
  ModelChoice choice;
  choice.file = file_->text().trimmed();
  if (has_own_name_) {
    choice.own_name = name_->text().trimmed();
  } else {
    choice.proposed_name = name_->text().trimmed();
  }
  (has_own_namespace_ ? choice.own_ns : choice.proposed_ns) = namespace_->text().trimmed();
  choice.is_numbered = is_numbered_->isChecked();
  choice.number = number_->value();
  return choice;
}

void SpawnDialog::Open(const QString& error, bool is_placed) {
  SetInputEnabled(true);
  Suggest();
  QPushButton* ok = buttons_->button(QDialogButtonBox::Ok);
  ok->setText(is_placed ? "&Spawn" : "&Place");
  ok->setToolTip(is_placed ? "Spawn it where it was placed." : "Choose its place by mouse.");
  if (!error.isEmpty()) message_->ShowError(error);
  open();
  raise();
  activateWindow();  // gives it the keyboard where there is no window manager
  const bool is_wrong_file = !error.isEmpty() && !is_placed;
  QLineEdit* first = file_->text().isEmpty() || is_wrong_file ? file_ : name_;
  first->setFocus();
  first->selectAll();
  ok->setDefault(true);  // while it was disabled, Enter has become Cancel's
}

void SpawnDialog::Wait(const QString& reason) {
  SetInputEnabled(false);
  message_->ShowInfo(reason);
}

void SpawnDialog::SetInputEnabled(bool is_enabled) {
  inputs_->setEnabled(is_enabled);
  buttons_->button(QDialogButtonBox::Ok)->setEnabled(is_enabled);
}

void SpawnDialog::accept() {
  if (choice().file.isEmpty()) {
    Open("Select the YAML file of a model.", false);
  } else {
    Q_EMIT Submitted(choice());
  }
}

}  // namespace flatland_viz
