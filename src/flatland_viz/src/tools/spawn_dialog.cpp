#include "spawn_dialog.hpp"

#include <QDialogButtonBox>
#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QKeyEvent>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QPlainTextEdit>
#include <QPushButton>
#include <QRegularExpression>
#include <QVBoxLayout>

#include "world_models.hpp"

namespace flatland_viz {
namespace {

constexpr int kFileRole = Qt::UserRole;
constexpr QSize kIcon(48, 48), kCell(124, 78);  // pixels
constexpr int kMessageLines = 4;

/// The name of a file without its folder and endings: "box" for "/models/box.model.yaml".
QString NameFromFile(const QString& file) {
  return QFileInfo(file).fileName().remove(QRegularExpression("(\\.model)?\\.ya?ml$"));
}

}  // namespace

SpawnDialog::SpawnDialog(QWidget* parent, const WorldModels& models)
    : QDialog(parent),
      models_(models),
      files_(models),
      search_(new QLineEdit),
      list_(new QListWidget),
      name_(new QLineEdit),
      namespace_(new QLineEdit),
      inputs_(new QWidget),
      message_(new QPlainTextEdit),
      buttons_(new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel)) {
  setObjectName("spawn_model_dialog");
  setWindowTitle("Spawn Model");
  list_->setObjectName("models");
  list_->setViewMode(QListView::IconMode);
  list_->setMovement(QListView::Static);
  list_->setResizeMode(QListView::Adjust);
  list_->setIconSize(kIcon);
  list_->setGridSize(kCell);
  list_->setWordWrap(true);
  list_->setTextElideMode(Qt::ElideMiddle);
  list_->setMinimumSize(3 * kCell.width() + 24, kCell.height() + 8);
  list_->setFocusPolicy(Qt::NoFocus);  // the field for the search moves the mark
  name_->setObjectName("name");
  namespace_->setObjectName("namespace");
  namespace_->setPlaceholderText("none");
  message_->setObjectName("message");
  message_->setReadOnly(true);  // its text can be copied
  message_->setFocusPolicy(Qt::ClickFocus);
  message_->setMaximumHeight(kMessageLines * fontMetrics().lineSpacing());
  message_->hide();

  auto* form = new QFormLayout(inputs_);
  form->setContentsMargins(0, 0, 0, 0);
  auto* search_label = new QLabel("&Find:");
  search_label->setBuddy(search_);
  form->addRow(search_label, MakeSearchRow());
  form->addRow(list_);
  form->addRow("&Name:", name_);
  form->addRow("Name&space:", namespace_);
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(inputs_);
  layout->addWidget(message_);
  layout->addWidget(buttons_);

  files_.Look();
  connect(&files_, &ModelFiles::Found, this, &SpawnDialog::ShowFiles);
  connect(&pictures_, &ModelPictures::Drawn, this, &SpawnDialog::SetPicture);
  connect(search_, &QLineEdit::textChanged, this, &SpawnDialog::Filter);
  connect(list_, &QListWidget::currentItemChanged, this, &SpawnDialog::Suggest);
  connect(list_, &QListWidget::itemClicked, this, &SpawnDialog::accept);
  connect(&models_, &WorldModels::Listed, this, &SpawnDialog::ShowFiles);
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

QWidget* SpawnDialog::MakeSearchRow() {
  search_->setObjectName("file");
  search_->setPlaceholderText("Part of a name, or a path");
  search_->installEventFilter(this);
  auto* select = new QPushButton("&Other file...");
  select->setObjectName("select_file");
  select->setAutoDefault(false);
  connect(select, &QPushButton::clicked, this, &SpawnDialog::SelectFile);

  auto* row = new QWidget;
  auto* layout = new QHBoxLayout(row);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(search_);
  layout->addWidget(select);
  return row;
}

/// Moves the mark by the arrow keys.
bool SpawnDialog::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() == QEvent::KeyPress) {
    const auto* key = static_cast<QKeyEvent*>(event);
    if (key->key() == Qt::Key_Up || key->key() == Qt::Key_Down) {
      const int step = key->key() == Qt::Key_Down ? 1 : -1;
      for (int row = list_->currentRow() + step; row >= 0 && row < list_->count(); row += step) {
        if (list_->item(row)->isHidden()) continue;
        list_->setCurrentRow(row);
        break;
      }
      return true;
    }
  }
  return QDialog::eventFilter(watched, event);
}

void SpawnDialog::ShowFiles() {
  if (!inputs_->isEnabled()) return;  // the choice is made
  const QString marked = file();
  QStringList unknown;
  list_->clear();
  for (const QString& file : files_.files()) {
    auto* item = new QListWidgetItem(icons_.value(file), NameFromFile(file), list_);
    item->setData(kFileRole, file);
    item->setToolTip(file);
    item->setTextAlignment(Qt::AlignHCenter | Qt::AlignTop);
    if (!icons_.contains(file)) unknown << file;
    if (file == marked) list_->setCurrentItem(item);
  }
  pictures_.Ask(unknown);
  Filter();
}

/// Shows the models with the text in their names, and marks one of them.
void SpawnDialog::Filter() {
  const QString text = search_->text().trimmed();
  const bool is_path = text.contains('/') || text.endsWith(".yaml") || text.endsWith(".yml");
  for (int row = 0; row < list_->count(); ++row) {
    QListWidgetItem* item = list_->item(row);
    item->setHidden(is_path || !item->text().contains(text, Qt::CaseInsensitive));
  }
  QListWidgetItem* marked = list_->currentItem();
  if (!marked || marked->isHidden()) {
    marked = nullptr;
    for (int row = list_->count() - 1; row >= 0; --row) {
      if (!list_->item(row)->isHidden()) marked = list_->item(row);
    }
    list_->setCurrentItem(marked);
  }
  Suggest();
}

void SpawnDialog::SetPicture(const QString& file, const QImage& picture) {
  icons_[file] = QIcon(QPixmap::fromImage(picture));
  for (int row = 0; row < list_->count(); ++row) {
    QListWidgetItem* item = list_->item(row);
    if (item->data(kFileRole).toString() == file) item->setIcon(icons_[file]);
  }
}

QString SpawnDialog::file() const {
  const QListWidgetItem* item = list_->currentItem();
  return item ? item->data(kFileRole).toString() : search_->text().trimmed();
}

QString SpawnDialog::name() const { return name_->text().trimmed(); }

QString SpawnDialog::ns() const {
  const QString ns = namespace_->text().trimmed();
  return has_own_namespace_ || ns.isEmpty() ? ns : "~" + ns;
}

void SpawnDialog::SelectFile() {
  const QFileInfo present(file());
  const bool has_folder = !file().isEmpty() && present.dir().exists();
  auto* chooser = new QFileDialog(this, "Select model file",
                                  has_folder ? present.absolutePath() : QDir::homePath(),
                                  "Models (*.yaml *.yml);;All files (*)");
  chooser->setObjectName("select_file_dialog");
  chooser->setAttribute(Qt::WA_DeleteOnClose);
  chooser->setFileMode(QFileDialog::ExistingFile);
  chooser->setOption(
      QFileDialog::DontUseNativeDialog);  // the same everywhere, and without a portal
  if (present.isFile()) chooser->selectFile(present.fileName());
  connect(chooser, &QFileDialog::fileSelected, search_, &QLineEdit::setText);
  connect(chooser, &QDialog::finished, this, [this] {
    activateWindow();
    name_->setFocus();
    name_->selectAll();
  });
  chooser->open();
  chooser->activateWindow();
}

void SpawnDialog::Suggest() {
  if (!has_own_name_ && !name_->hasFocus()) {
    name_->setText(models_.FreeName(NameFromFile(file())));
  }
  if (!has_own_namespace_) namespace_->setText(models_.FindTwin(file(), "") ? name() : QString());
  WarnOfTwin();
}

void SpawnDialog::WarnOfTwin() {
  const WorldModel* twin = models_.FindTwin(file(), namespace_->text().trimmed().toStdString());
  if (!twin) {
    Say({});
    return;
  }
  const QString name = QString::fromStdString(twin->info.name);
  const QString commands = QString::fromStdString(twin->command_topic());
  Say(commands.isEmpty()
          ? QString("%1 has the same topics. Give this one a namespace.").arg(name)
          : QString("%1 listens to %2, too: one command would drive both. Give this one a "
                    "namespace.")
                .arg(name, commands));
}

void SpawnDialog::Say(const QString& message, bool is_error) {
  const bool is_dark = palette().color(QPalette::Window).lightness() < 128;
  const char* const red = is_dark ? "color: #ff8075" : "color: #c62828";
  message_->setStyleSheet(is_error ? red : "");
  message_->setPlainText(message);
  message_->setVisible(!message.isEmpty());
  layout()->activate();
  resize(width(), layout()->sizeHint().height());
}

void SpawnDialog::Open(const QString& error, bool is_placed) {
  SetInputEnabled(true);
  ShowFiles();
  QPushButton* ok = buttons_->button(QDialogButtonBox::Ok);
  ok->setText(is_placed ? "&Spawn" : "&Place");
  ok->setToolTip(is_placed ? "Spawn it where it was placed."
                           : "Choose its place by mouse: press, drag to turn it, release.");
  if (!error.isEmpty()) Say(error, true);
  open();
  raise();
  activateWindow();  // gives it the keyboard where there is no window manager
  QLineEdit* first = is_placed ? name_ : search_;
  first->setFocus();
  first->selectAll();
  ok->setDefault(true);  // while it was disabled, Cancel became the default
}

void SpawnDialog::Remember() { files_.AddRecent(file()); }

void SpawnDialog::Wait(const QString& reason) {
  SetInputEnabled(false);
  Say(reason);
}

void SpawnDialog::SetInputEnabled(bool is_enabled) {
  inputs_->setEnabled(is_enabled);
  buttons_->button(QDialogButtonBox::Ok)->setEnabled(is_enabled);
}

void SpawnDialog::accept() {
  if (file().isEmpty()) {
    Open("Choose a model, or type the path of its file.", false);
  } else {
    Q_EMIT Submitted();
  }
}

}  // namespace flatland_viz
