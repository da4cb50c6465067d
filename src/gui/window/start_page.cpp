// SPDX-License-Identifier: Apache-2.0
#include "gui/window/start_page.h"

#include <QAction>
#include <QDir>
#include <QEvent>
#include <QFileInfo>
#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QToolButton>
#include <QVBoxLayout>

#include "core/error.h"
#include "gui/input/action_table.h"
#include "gui/look/qt_text.h"
#include "gui/look/symbols.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "io/platform/data_path.h"

namespace simplexseg {
namespace {

constexpr int kPageWidth = 440;
constexpr int kMostRecent = 5;

/// Path of the sample image of a head in Debian's package mricron-data; empty if it is not installed.
QString sample_head() {
  try {
    return text(find_data("ch2.nii.gz", {}));
  } catch (const Error&) {
    return {};
  }
}

QLabel* dim_label(const QString& text, QWidget* parent) {
  auto* label = new QLabel(text, parent);
  set_role(label, "dim");
  return label;
}

}  // namespace

StartPage::StartPage(ActionTable& actions, QWidget* over) : QWidget(over) {
  setObjectName("start_page");
  setAttribute(Qt::WA_StyledBackground);
  auto* page = new QHBoxLayout(this);
  auto* middle = new QWidget(this);
  middle->setMaximumWidth(theme::scaled(kPageWidth));
  middle->setMinimumWidth(theme::scaled(280));
  auto* column = new QVBoxLayout(middle);
  column->setSpacing(8);
  column->addStretch(1);
  auto* title = new QLabel(tr("Segment a volume"), middle);
  title->setObjectName("title");
  column->addWidget(title);
  column->addWidget(dim_label(tr("Open a file, or drop a file or a DICOM folder here."), middle));
  column->addSpacing(6);
  const auto add_entry = [&](Act act, Symbol symbol, const char* name) {
    auto* button = new QToolButton(middle);
    button->setObjectName(name);
    button->setIcon(icon_of(symbol, qstrcmp(name, "first_entry") == 0 ? QColor(Qt::white) : QColor()));
    button->setIconSize({20, 20});
    button->setText("  " + actions[act]->statusTip() + "    " +
                    actions[act]->shortcut().toString(QKeySequence::NativeText));
    button->setToolTip(actions[act]->statusTip());
    button->setFocusPolicy(Qt::StrongFocus);
    // Not setDefaultAction(): a change of the action would replace label and icon by those of the menu.
    QAction* const action = actions[act];
    connect(button, &QToolButton::clicked, action, &QAction::trigger);
    const auto follow = [button, action] { set_enabled(button, action->isEnabled(), action->toolTip()); };
    connect(action, &QAction::changed, button, follow);
    follow();
    button->setToolButtonStyle(Qt::ToolButtonTextBesideIcon);
    button->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
    column->addWidget(button);
  };
  add_entry(Act::Open, Symbol::Open, "first_entry");
  add_entry(Act::OpenFolder, Symbol::Folder, "entry");
  recent_ = new QWidget(middle);
  recent_column_ = new QVBoxLayout(recent_);
  recent_column_->setContentsMargins(0, 12, 0, 0);
  recent_column_->setSpacing(2);
  column->addWidget(recent_);
  column->addStretch(2);
  page->addStretch(1);
  page->addWidget(middle, 6);
  page->addStretch(1);
  show_recent({});
  over->installEventFilter(this);
  setGeometry(over->rect());
}

bool StartPage::eventFilter(QObject* watched, QEvent* event) {
  if (watched == parent() && event->type() == QEvent::Resize) setGeometry(parentWidget()->rect());
  return QWidget::eventFilter(watched, event);
}

void StartPage::add_path(const QString& title, const QString& path) {
  auto* button = new QPushButton(recent_);
  button->setObjectName("recent");
  button->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Fixed);
  button->setText(button->fontMetrics().elidedText(title, Qt::ElideMiddle, theme::scaled(kPageWidth) - 40));
  button->setToolTip(QDir::toNativeSeparators(path));
  connect(button, &QPushButton::clicked, this, [this, path] { emit open_requested(path); });
  recent_column_->addWidget(button);
}

void StartPage::show_recent(const QStringList& paths) {
  while (QLayoutItem* item = recent_column_->takeAt(0)) {
    if (item->widget()) item->widget()->deleteLater();
    delete item;
  }
  int shown = 0;
  for (const QString& path : paths) {
    const QFileInfo file(path);
    if (!path_exists(path) || shown == kMostRecent) continue;
    if (shown++ == 0) recent_column_->addWidget(dim_label(tr("Recent"), recent_));
    add_path(file.fileName() + "    " + QDir::toNativeSeparators(file.absolutePath()), path);
  }
  const QString sample = sample_head();
  if (sample.isEmpty()) return;
  if (shown > 0) recent_column_->addSpacing(8);
  recent_column_->addWidget(dim_label(tr("Example"), recent_));
  add_path(tr("Sample head (T1)"), sample);
}

}  // namespace simplexseg
