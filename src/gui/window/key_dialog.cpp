// SPDX-License-Identifier: Apache-2.0
#include "gui/window/key_dialog.h"

#include <QDialogButtonBox>
#include <QEvent>
#include <QFileDialog>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QKeyEvent>
#include <QKeySequenceEdit>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QTreeWidget>
#include <QVBoxLayout>

#include "gui/input/key_map.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/window/key_file.h"

namespace simplexseg {
namespace {

constexpr int kActRole = Qt::UserRole;

/// Title in the list; tools are named as such, because other actions have similar titles.
QString row_title(const Binding& binding) {
  const QString title = title_of(binding.act);
  return QByteArray(binding.help).startsWith("Tool: ") ? QObject::tr("Tool: %1").arg(title) : title;
}

QString shown(const QKeySequence& key) { return key.toString(QKeySequence::NativeText); }

}  // namespace

KeyDialog::KeyDialog(QWidget* parent) : QDialog(parent), keys_(KeyMap::shared().keys()) {
  setObjectName("key_dialog");
  setWindowTitle(tr("Change keys"));
  setAttribute(Qt::WA_DeleteOnClose);
  auto* layout = new QVBoxLayout(this);
  search_ = new QLineEdit(this);
  search_->setPlaceholderText(tr("Search actions and keys"));
  search_->setAccessibleName(tr("Search actions and keys"));
  search_->setClearButtonEnabled(true);
  connect(search_, &QLineEdit::textChanged, this, &KeyDialog::filter);
  layout->addWidget(search_);
  build_list();
  build_editor();
  build_buttons();
  refresh();
  list_->setCurrentItem(list_->topLevelItem(0)->child(0));
  search_->setFocus();
  resize(640, 620);
  fit_on_screen(*this);
}

void KeyDialog::build_list() {
  list_ = new QTreeWidget(this);
  list_->setAccessibleName(tr("Actions and keys"));
  list_->setColumnCount(3);
  list_->setHeaderLabels({tr("Action"), tr("Key"), tr("Default")});
  list_->setRootIsDecorated(false);
  list_->setIndentation(14);
  list_->setUniformRowHeights(true);
  list_->header()->setStretchLastSection(false);
  list_->header()->setSectionResizeMode(0, QHeaderView::Stretch);
  list_->header()->setSectionResizeMode(1, QHeaderView::ResizeToContents);
  list_->header()->setSectionResizeMode(2, QHeaderView::ResizeToContents);
  for (const Where where : {Where::Everywhere, Where::Slices, Where::Space}) {
    auto* group = new QTreeWidgetItem({QString::fromLatin1(where_name(where))});
    for (const Binding& binding : bindings()) {
      if (binding.where != where || !*binding.keys) continue;
      auto* row = new QTreeWidgetItem(group, {row_title(binding)});
      row->setData(0, kActRole, static_cast<int>(binding.act));
      row->setToolTip(0, QString::fromUtf8(binding.help));
    }
    if (group->childCount() == 0) {
      delete group;
      continue;
    }
    group->setFlags(Qt::ItemIsEnabled);
    QFont bold = list_->font();
    bold.setBold(true);
    group->setFont(0, bold);
    group->setFirstColumnSpanned(true);
    list_->addTopLevelItem(group);
    group->setExpanded(true);
  }
  connect(list_, &QTreeWidget::currentItemChanged, this, [this] {
    show_line({});
    refresh();
  });
  connect(list_, &QTreeWidget::itemActivated, this, [this] {
    if (selected()) edit_->setFocus();
  });
  layout()->addWidget(list_);
}

void KeyDialog::build_editor() {
  auto* row = new QHBoxLayout;
  auto* label = new QLabel(tr("New &key:"), this);
  edit_ = new QKeySequenceEdit(this);
  edit_->setAccessibleName(tr("New key"));
  edit_->setToolTip(tr("Click here and press the key for the selected action"));
  edit_->installEventFilter(this);
  label->setBuddy(edit_);
  none_ = new QPushButton(tr("&No key"), this);
  none_->setToolTip(tr("The selected action gets no key"));
  reset_ = new QPushButton(tr("&Default"), this);
  row->addWidget(label);
  row->addWidget(edit_, 1);
  row->addWidget(none_);
  row->addWidget(reset_);
  static_cast<QVBoxLayout*>(layout())->addLayout(row);
  auto* messages = new QHBoxLayout;
  line_ = new QLabel(this);
  line_->setObjectName("key_message");
  line_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
  take_over_ = new QPushButton(tr("&Take over"), this);
  take_over_->setObjectName("take_over");
  messages->addWidget(line_, 1);
  messages->addWidget(take_over_);
  static_cast<QVBoxLayout*>(layout())->addLayout(messages);
  // The line keeps its height while the button is hidden.
  line_->setMinimumHeight(take_over_->sizeHint().height());
  take_over_->hide();
  auto* mouse =
      new QLabel(tr("Mouse gestures, and the keys Shift, Ctrl and Alt held with them, cannot be changed."), this);
  mouse->setWordWrap(true);
  set_role(mouse, "dim");
  layout()->addWidget(mouse);
  connect(none_, &QPushButton::clicked, this, [this] { use({}); });
  connect(reset_, &QPushButton::clicked, this,
          [this] { use(QKeySequence(QString::fromLatin1(binding_of(*selected()).keys))); });
  connect(take_over_, &QPushButton::clicked, this, &KeyDialog::take_over);
}

void KeyDialog::build_buttons() {
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel, this);
  const auto add = [&](const QString& text, const QString& tip, const auto& action) {
    QPushButton* const button = buttons->addButton(text, QDialogButtonBox::ResetRole);
    button->setToolTip(tip);
    button->setAutoDefault(false);
    connect(button, &QPushButton::clicked, this, action);
  };
  add(tr("&All defaults"), tr("Every action gets its default key"), [this] {
    keys_.reset_all();
    show_line({});
    refresh();
  });
  const QString filter = tr("Keys (*.json)");
  add(tr("&Import..."), tr("Replace the keys by those of a file"), [this, filter] {
    const QString path = local_path(QFileDialog::getOpenFileUrl(this, tr("Import keys"), {}, filter));
    if (!path.isEmpty()) import_from(path);
  });
  add(tr("&Export..."), tr("Write the changed keys to a file"), [this, filter] {
    QString path = local_path(QFileDialog::getSaveFileUrl(this, tr("Export keys"), url_of("keys.json"), filter));
    if (path.isEmpty()) return;
    export_to(path.endsWith(".json") ? path : path + ".json");
  });
  for (QPushButton* button : {none_, reset_, take_over_}) button->setAutoDefault(false);
  connect(buttons, &QDialogButtonBox::accepted, this, [this] {
    KeyMap::shared().assign(keys_);
    accept();
  });
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  layout()->addWidget(buttons);
}

std::optional<Act> KeyDialog::selected() const {
  const QTreeWidgetItem* row = list_->currentItem();
  const QVariant act = row ? row->data(0, kActRole) : QVariant();
  if (!act.isValid()) return std::nullopt;
  return static_cast<Act>(act.toInt());
}

void KeyDialog::refresh() {
  for (int g = 0; g < list_->topLevelItemCount(); ++g)
    for (int n = 0; n < list_->topLevelItem(g)->childCount(); ++n) {
      QTreeWidgetItem* row = list_->topLevelItem(g)->child(n);
      const auto act = static_cast<Act>(row->data(0, kActRole).toInt());
      const bool changed = keys_.is_changed(act);
      QFont font = list_->font();
      font.setBold(changed);
      row->setFont(1, font);
      const QKeySequence key = keys_.key_of(act);
      row->setText(1, key.isEmpty() ? tr("none") : shown(key));
      row->setText(2, changed ? shown(QKeySequence(QString::fromLatin1(binding_of(act).keys))) : QString());
    }
  const std::optional<Act> act = selected();
  if (!wanted_) edit_->setKeySequence(act ? keys_.key_of(*act) : QKeySequence());
  const QString none = tr("No action is selected");
  set_enabled(edit_, act.has_value(), none);
  set_enabled(none_, act && !keys_.key_of(*act).isEmpty(), act ? tr("It has no key") : none);
  set_enabled(reset_, act && keys_.is_changed(*act), act ? tr("It has its default key") : none);
}

void KeyDialog::filter(const QString& text) {
  for (int g = 0; g < list_->topLevelItemCount(); ++g) {
    bool any = false;
    for (int n = 0; n < list_->topLevelItem(g)->childCount(); ++n) {
      QTreeWidgetItem* row = list_->topLevelItem(g)->child(n);
      const bool fits =
          (row->text(0) + '\n' + row->toolTip(0) + '\n' + row->text(1)).contains(text, Qt::CaseInsensitive);
      row->setHidden(!fits);
      any |= fits;
    }
    list_->topLevelItem(g)->setHidden(!any);
  }
}

void KeyDialog::use(const QKeySequence& key) {
  const std::optional<Act> act = selected();
  if (!act) return;
  if (const std::optional<Act> other = keys_.act_with(key, act)) {
    show_line(tr("%1 is the key of '%2', which would have none.").arg(shown(key), title_of(*other)));
    wanted_ = key;
    take_over_->show();
    return;
  }
  const QString defect = key.isEmpty() ? QString() : defect_of_key(key);
  if (defect.isEmpty()) {
    keys_.set(*act, key);
    show_line({});
  } else {
    show_line(tr("%1 cannot be used: %2.").arg(shown(key), defect));
  }
  refresh();
}

void KeyDialog::take_over() {
  const std::optional<Act> act = selected();
  if (act && wanted_) keys_.set(*act, *wanted_);
  show_line({});
  refresh();
}

void KeyDialog::show_line(const QString& text) {
  wanted_.reset();
  line_->setText(text);
  line_->setToolTip(text);
  take_over_->hide();
}

void KeyDialog::import_from(const QString& path) {
  try {
    keys_ = read_key_file(to_path(path));
    show_line(tr("Imported: %1").arg(path));
  } catch (const std::exception& error) {
    show_line(QString::fromUtf8(error.what()));
  }
  refresh();
}

void KeyDialog::export_to(const QString& path) {
  try {
    write_key_file(to_path(path), keys_);
    show_line(tr("Exported: %1").arg(path));
  } catch (const std::exception& error) {
    show_line(QString::fromUtf8(error.what()));
  }
}

// All keys but those that move the focus go to the field, also those of buttons and menus. The field itself would wait
// for further keys of a sequence.
bool KeyDialog::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() != QEvent::ShortcutOverride && event->type() != QEvent::KeyPress)
    return QDialog::eventFilter(watched, event);
  const auto& pressed = *static_cast<QKeyEvent*>(event);
  if (pressed.key() == Qt::Key_Tab || pressed.key() == Qt::Key_Backtab) return false;
  event->accept();
  const QKeySequence key = key_of_event(pressed);
  if (event->type() == QEvent::KeyPress && !key.isEmpty()) {
    edit_->setKeySequence(key);
    use(key);
  }
  return true;
}

}  // namespace simplexseg
