// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/name_line.h"

#include <QApplication>
#include <QKeyEvent>
#include <QListWidget>
#include <algorithm>

#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/workbench/naming.h"

namespace simplexseg {
namespace {

constexpr std::size_t kMostSuggestions = 8;

}  // namespace

NameLine::NameLine(std::function<std::vector<PresetLabel>()> labels, QWidget* parent)
    : QLineEdit(parent), load_(std::move(labels)), list_(new QListWidget(this)) {
  list_->setObjectName("name_suggestions");
  list_->setAccessibleName(tr("Suggested names"));
  list_->setFocusPolicy(Qt::NoFocus);
  list_->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  list_->setVerticalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  list_->hide();
  connect(this, &QLineEdit::textEdited, this, &NameLine::suggest);
  connect(list_.data(), &QListWidget::itemPressed, this, [this] {
    QPointer<NameLine> line(this);  // accepting can delete the field
    accept_row();
    if (!line) return;
    list_->hide();
    clearFocus();
  });
}

NameLine::~NameLine() {
  if (qApp) qApp->removeEventFilter(this);
  delete list_.data();
}

QListWidget& NameLine::list() const { return *list_; }

void NameLine::suggest(const QString& typed) {
  if (labels_.empty()) labels_ = load_();
  const std::string sought = typed.trimmed().toStdString();
  matches_ = sought.empty() ? std::vector<const PresetLabel*>() : matching_labels(labels_, sought);
  if (matches_.size() > kMostSuggestions) matches_.resize(kMostSuggestions);
  list_->clear();
  for (const PresetLabel* label : matches_) {
    auto* row = new QListWidgetItem(swatch(label->colour), simplexseg::text(label->name), list_);
    row->setToolTip(text_of_code(label->code));
  }
  if (matches_.empty()) {
    list_->hide();
    return;
  }
  auto* literal = new QListWidgetItem(tr("Keep \"%1\"").arg(typed.trimmed()), list_);
  QFont font = list_->font();
  font.setItalic(true);
  literal->setFont(font);
  list_->setCurrentRow(0);
  show_list();
}

void NameLine::show_list() {
  list_->setParent(window());  // over the neighbouring widgets
  list_->ensurePolished();
  const QPoint below = mapTo(window(), QPoint(0, height()));
  int high = 2 * list_->frameWidth() + 2;
  for (int row = 0; row < list_->count(); ++row) high += list_->sizeHintForRow(row);
  const int wide = std::max(width(), list_->sizeHintForColumn(0) + 2 * list_->frameWidth() + 8);
  const int y = below.y() + high <= window()->height() ? below.y() : below.y() - height() - high;
  list_->setGeometry(std::clamp(below.x(), 0, std::max(0, window()->width() - wide)), std::max(0, y), wide, high);
  list_->show();
  list_->raise();
}

bool NameLine::accept_row() {
  const auto row = static_cast<std::size_t>(std::max(0, list_->currentRow()));
  if (row >= matches_.size()) return false;
  const PresetLabel label = *matches_[row];
  setText(simplexseg::text(label.name));
  setModified(false);
  emit chosen(label);
  return true;
}

// Filters the events of the application while the field has the focus, because FocusReturn moves the focus when Enter
// is pressed, before the field receives the key.
bool NameLine::eventFilter(QObject* watched, QEvent* event) {
  if (watched != this || event->type() != QEvent::KeyPress || list_->isHidden()) return false;
  const int key = static_cast<QKeyEvent*>(event)->key();
  if (key == Qt::Key_Up || key == Qt::Key_Down) {
    const int rows = list_->count();
    list_->setCurrentRow((list_->currentRow() + (key == Qt::Key_Down ? 1 : rows - 1)) % rows);
    return true;
  }
  if (key == Qt::Key_Return || key == Qt::Key_Enter) {
    QPointer<NameLine> line(this);
    accept_row();
    if (line) list_->hide();
  }
  return false;  // FocusReturn moves the focus
}

void NameLine::focusInEvent(QFocusEvent* event) {
  labels_.clear();  // the preset can have changed
  QApplication::instance()->installEventFilter(this);
  QLineEdit::focusInEvent(event);
}

void NameLine::focusOutEvent(QFocusEvent* event) {
  QApplication::instance()->removeEventFilter(this);
  list_->hide();
  QLineEdit::focusOutEvent(event);
}

}  // namespace simplexseg
