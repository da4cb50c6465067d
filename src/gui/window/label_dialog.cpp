// SPDX-License-Identifier: Apache-2.0
#include "gui/window/label_dialog.h"

#include <QDialogButtonBox>
#include <QHeaderView>
#include <QLabel>
#include <QLineEdit>
#include <QLocale>
#include <QPushButton>
#include <QTreeWidget>
#include <QVBoxLayout>

#include "core/number_text.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"

namespace simplexseg {

LabelDialog::LabelDialog(std::vector<LabelCount> labels, QWidget* parent)
    : QDialog(parent), labels_(std::move(labels)), list_(new QTreeWidget(this)) {
  setObjectName("label_dialog");
  setWindowTitle(tr("Segmentations from labels"));
  resize(460, 420);
  fit_on_screen(*this);
  auto* column = new QVBoxLayout(this);
  column->addWidget(
      new QLabel(tr("Tick the labels to import. Each becomes a segmentation that you can correct."), this));
  auto* search = new QLineEdit(this);
  search->setPlaceholderText(tr("Find by number or name"));
  search->setAccessibleName(tr("Find a label"));
  search->setClearButtonEnabled(true);
  column->addWidget(search);
  list_->setAccessibleName(tr("Labels"));
  list_->setHeaderLabels({tr("Label"), tr("Name"), tr("Voxels"), tr("Volume")});
  list_->setRootIsDecorated(false);
  list_->setUniformRowHeights(true);
  for (const LabelCount& label : labels_) {
    auto* item = new QTreeWidgetItem(list_);
    item->setText(0, QString::number(label.value, 'g', 10));
    item->setText(1, QString::fromStdString(label.name));
    item->setText(2, QLocale::c().toString(static_cast<qulonglong>(label.voxels)));
    item->setText(3, text(volume_text(1000 * label.millilitres)));
    for (const int number : {2, 3}) item->setTextAlignment(number, Qt::AlignRight | Qt::AlignVCenter);
    if (label.colour) item->setIcon(1, swatch(*label.colour));
    item->setCheckState(0, labels_.size() == 1 ? Qt::Checked : Qt::Unchecked);
  }
  for (int c = 0; c < 4; ++c) list_->resizeColumnToContents(c);
  column->addWidget(list_, 1);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel, this);
  create_ = buttons->button(QDialogButtonBox::Ok);
  column->addWidget(buttons);
  connect(buttons, &QDialogButtonBox::accepted, this, &QDialog::accept);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  connect(list_, &QTreeWidget::itemChanged, this, &LabelDialog::refresh);
  connect(search, &QLineEdit::textChanged, this, [this](const QString& sought) {
    for (int n = 0; n < list_->topLevelItemCount(); ++n) {
      QTreeWidgetItem* item = list_->topLevelItem(n);
      item->setHidden(!item->text(0).startsWith(sought) && !item->text(1).contains(sought, Qt::CaseInsensitive));
    }
  });
  refresh();
}

std::vector<LabelCount> LabelDialog::chosen() const {
  std::vector<LabelCount> chosen;
  for (int n = 0; n < list_->topLevelItemCount(); ++n)
    if (list_->topLevelItem(n)->checkState(0) == Qt::Checked) chosen.push_back(labels_[static_cast<std::size_t>(n)]);
  return chosen;
}

void LabelDialog::refresh() {
  const auto count = static_cast<int>(chosen().size());
  create_->setText(tr("Create %1").arg(counted_text(count, "segmentation")));
  set_enabled(create_, count > 0, tr("Tick a label first"));
}

}  // namespace simplexseg
