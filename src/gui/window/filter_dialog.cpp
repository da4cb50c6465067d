// SPDX-License-Identifier: Apache-2.0
#include "gui/window/filter_dialog.h"

#include <QComboBox>
#include <QDialogButtonBox>
#include <QFormLayout>
#include <QLabel>
#include <QListWidget>
#include <QPushButton>
#include <QStandardItemModel>
#include <QVBoxLayout>
#include <cmath>

#include "gui/look/number_box.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"

namespace simplexseg {
namespace {
constexpr int kRowsBefore = 2;  ///< rows of the form before the parameters
QString capitalised(const char* text) {
  QString title = QObject::tr(text);
  title[0] = title[0].toUpper();
  return title;
}
}  // namespace

FilterDialog::FilterDialog(const QString& title, std::vector<FilterStep> present, bool keeps_grid, QWidget* parent)
    : QDialog(parent),
      filters_(std::move(present)),
      kind_(new QComboBox(this)),
      help_(new QLabel(this)),
      form_(new QFormLayout) {
  setObjectName("filter_dialog");
  setWindowTitle(title);
  auto* column = new QVBoxLayout(this);
  auto* hint = new QLabel(tr("The file stays as it is: the scene has the filters with their parameters, and their "
                             "result is computed when the scene is opened. They are applied in this order."),
                          this);
  hint->setWordWrap(true);
  column->addWidget(hint);
  if (!filters_.empty()) {
    auto* list = new QListWidget(this);
    list->setObjectName("filter_list");
    list->setAccessibleName(tr("Present filters"));
    list->setSelectionMode(QAbstractItemView::NoSelection);
    list->setFocusPolicy(Qt::NoFocus);
    for (std::size_t n = 0; n < filters_.size(); ++n)
      list->addItem(QString("%1. %2").arg(n + 1).arg(text(describe(std::span(&filters_[n], 1)))));
    const int rows = std::min(list->count(), 5);
    list->setFixedHeight(rows * list->sizeHintForRow(0) + 2 * list->frameWidth());
    auto* remove = new QPushButton(tr("Remove &last"), this);
    remove->setObjectName("remove_filter");
    remove->setToolTip(tr("Use the image without the last of these filters"));
    remove->setAutoDefault(false);
    connect(remove, &QPushButton::clicked, this, [this] {
      filters_.pop_back();
      QDialog::accept();
    });
    column->addWidget(list);
    auto* row = new QHBoxLayout;
    row->addStretch();
    row->addWidget(remove);
    column->addLayout(row);
  }
  kind_->setObjectName("filter_kind");
  for (const FilterInfo& info : filter_list()) {
    if (!info.uses_itk) continue;  // uptake values: when a PET series is opened
    kind_->addItem(tr(info.title), static_cast<int>(info.kind));
    if (!keeps_grid || info.keeps_grid) continue;
    auto* const item = qobject_cast<QStandardItemModel*>(kind_->model())->item(kind_->count() - 1);
    item->setEnabled(false);
    item->setToolTip(
        tr("Changes the grid, which marks, paint and labels have. Filter the file by the command line "
           "and open the result."));
  }
  help_->setWordWrap(true);
  set_role(help_, "dim");
  form_->addRow(tr("&Filter:"), kind_);
  form_->addRow(help_);
  column->addLayout(form_);
  column->addStretch();
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel, this);
  buttons->button(QDialogButtonBox::Ok)->setText(tr("&Apply"));
  buttons->button(QDialogButtonBox::Ok)->setDefault(true);
  column->addWidget(buttons);
  connect(buttons, &QDialogButtonBox::accepted, this, [this] {
    filters_.push_back(chosen());
    accept();
  });
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  connect(kind_, &QComboBox::currentIndexChanged, this, &FilterDialog::show_parameters);
  show_parameters();
  resize(470, sizeHint().height());
  fit_on_screen(*this);
}

void FilterDialog::show_parameters() {
  while (form_->rowCount() > kRowsBefore) form_->removeRow(form_->rowCount() - 1);
  values_.clear();
  const FilterInfo& info = info_of(static_cast<FilterKind>(kind_->currentData().toInt()));
  help_->setText(tr(info.help));
  for (const FilterParameter& parameter : info.parameters) {
    auto* box = new NumberBox(this);
    box->setObjectName(QString("filter_") + parameter.name);
    box->setDecimals(parameter.integer ? 0 : 2);
    box->setRange(parameter.min, parameter.max);
    box->setValue(parameter.value);
    box->setToolTip(capitalised(parameter.help));
    box->setAccessibleName(capitalised(parameter.name));
    form_->addRow(capitalised(parameter.name) + ":", box);
    form_->labelForField(box)->setToolTip(box->toolTip());
    values_.push_back(box);
  }
}

FilterStep FilterDialog::chosen() const {
  FilterStep step{static_cast<FilterKind>(kind_->currentData().toInt()), {}};
  for (const QDoubleSpinBox* box : values_) step.parameters.push_back(box->value());
  return step;
}

}  // namespace simplexseg
