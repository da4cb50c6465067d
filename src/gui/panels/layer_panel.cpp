// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/layer_panel.h"

#include <QAction>
#include <QComboBox>
#include <QFileInfo>
#include <QGridLayout>
#include <QHeaderView>
#include <QLabel>
#include <QSignalBlocker>
#include <QSlider>
#include <QToolButton>
#include <QTreeWidget>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "gui/input/action_table.h"
#include "gui/look/number_box.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/workbench/workbench.h"

namespace simplexseg {
namespace {
constexpr double kLargestBoxValue = 1e9;
ItemId layer_in(const QTreeWidgetItem* row) { return row->data(0, Qt::UserRole).toUInt(); }
}  // namespace

LayerPanel::LayerPanel(Workbench& workbench, ActionTable& actions, QWidget* parent)
    : QWidget(parent),
      workbench_(workbench),
      list_(new QTreeWidget(this)),
      colours_(new QComboBox(this)),
      opacity_(new QSlider(Qt::Horizontal, this)),
      percent_(new QLabel(this)),
      window_(new NumberBox(this)),
      level_(new NumberBox(this)),
      unit_(new QLabel(this)),
      transform_(new QLabel(this)),
      filters_(new QLabel(this)),
      volume_(new QLabel(this)) {
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(8, 6, 8, 6);
  list_->setObjectName("layer_list");
  list_->setAccessibleName(tr("Layers"));
  list_->setHeaderLabels({tr("Layer"), tr("Colours")});
  list_->header()->setSectionResizeMode(0, QHeaderView::Stretch);
  list_->header()->setSectionResizeMode(1, QHeaderView::ResizeToContents);
  list_->header()->setStretchLastSection(false);
  list_->setRootIsDecorated(false);
  list_->setToolTip(tr("Check mark: shown. Double-click a name to rename the layer. The last layer is drawn on top."));
  layout->addWidget(list_, 1);

  auto* form = new QGridLayout;
  form->setColumnStretch(1, 1);
  form->setColumnStretch(3, 1);
  const auto add_label = [&](int row, int column, const QString& title, QWidget* control, const QString& tip) {
    auto* label = new QLabel(title, this);
    label->setBuddy(control);
    control->setToolTip(tip);
    control->setAccessibleName(title);
    form->addWidget(label, row, column);
  };
  add_label(0, 0, tr("Colours"), colours_, tr("Colour map of the layer"));
  form->addWidget(colours_, 0, 1, 1, 4);
  for (const ColourMapInfo& info : colour_maps()) colours_->addItem(tr(info.title));
  add_label(1, 0, tr("Opacity"), opacity_, tr("Opacity of the layer in a blend"));
  opacity_->setRange(0, 100);
  opacity_->setObjectName("layer_opacity");
  auto* opacity = new QHBoxLayout;
  opacity->addWidget(opacity_, 1);
  percent_->setMinimumWidth(percent_->fontMetrics().horizontalAdvance("100%"));
  percent_->setAlignment(Qt::AlignRight | Qt::AlignVCenter);
  opacity->addWidget(percent_);
  form->addLayout(opacity, 1, 1, 1, 4);
  add_label(2, 0, tr("Window"), window_, tr("Difference of the values with the first and the last colour"));
  add_label(2, 2, tr("Level"), level_, tr("Value with the colour in the middle"));
  form->addWidget(window_, 2, 1);
  form->addWidget(level_, 2, 3);
  form->addWidget(unit_, 2, 4);
  window_->setObjectName("layer_window");
  level_->setObjectName("layer_level");
  window_->setRange(1e-9, kLargestBoxValue);
  level_->setRange(-kLargestBoxValue, kLargestBoxValue);
  for (QDoubleSpinBox* box : {window_, level_}) {
    box->setKeyboardTracking(false);
    box->setStepType(QAbstractSpinBox::AdaptiveDecimalStepType);
  }
  layout->addLayout(form);
  transform_->setObjectName("layer_transform");
  filters_->setObjectName("layer_filters");
  volume_->setObjectName("volume_filters");
  for (QLabel* label : {transform_, filters_, volume_}) {
    label->setWordWrap(true);
    label->setTextInteractionFlags(Qt::TextSelectableByMouse);
    set_role(label, "dim");
    layout->addWidget(label);
  }
  constexpr int kButtonsInRow = 3;
  auto* buttons = new QGridLayout;
  const std::pair<Act, QString> entries[] = {{Act::AddLayer, tr("Add...")},
                                             {Act::RegisterLayer, tr("Register...")},
                                             {Act::FilterLayer, tr("Filter...")},
                                             {Act::LayerContrast, tr("Contrast")},
                                             {Act::RemoveLayer, tr("Remove")}};
  for (const auto& [act, title] : entries) {
    auto* button = new QToolButton(this);
    actions[act]->setIconText(title);
    button->setDefaultAction(actions[act]);
    button->setToolButtonStyle(Qt::ToolButtonTextOnly);
    set_role(button, "raised");
    button->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
    buttons->addWidget(button, buttons->count() / kButtonsInRow, buttons->count() % kButtonsInRow);
  }
  layout->addLayout(buttons);

  connect(list_, &QTreeWidget::currentItemChanged, this, [this](const QTreeWidgetItem* row) {
    if (!row || workbench_.view.active_layer == layer_in(row)) return;
    workbench_.view.active_layer = layer_in(row);
    refresh();
    workbench_.view_edited();
  });
  connect(list_, &QTreeWidget::itemChanged, this, &LayerPanel::edit_row);
  connect(colours_, &QComboBox::activated, this, [this](int index) {
    const LayerItem* const layer = active();
    const ColourMap map = colour_maps()[static_cast<std::size_t>(index)].map;
    if (!layer || layer->colour_map == map) return;
    EditLayer edit{layer->id};
    edit.colour_map = map;
    workbench_.apply(edit);
  });
  connect(opacity_, &QSlider::sliderPressed, this, [this] { opacity_dragged_ = false; });
  connect(opacity_, &QSlider::valueChanged, this, &LayerPanel::set_opacity);
  connect(window_, &QDoubleSpinBox::valueChanged, this, &LayerPanel::set_contrast);
  connect(level_, &QDoubleSpinBox::valueChanged, this, &LayerPanel::set_contrast);
  connect(&workbench_, &Workbench::scene_changed, this, &LayerPanel::refresh);
  connect(&workbench_, &Workbench::layer_images_changed, this, &LayerPanel::refresh);
  refresh();
}

const LayerItem* LayerPanel::active() const { return workbench_.scene().find_layer(workbench_.view.active_layer); }

void LayerPanel::edit_row(QTreeWidgetItem* row) {
  const LayerItem* const layer = workbench_.scene().find_layer(layer_in(row));
  if (!layer) return;
  EditLayer edit{layer->id};
  const bool visible = row->checkState(0) == Qt::Checked;
  const std::string name = row->text(0).toStdString();
  if (visible != layer->visible)
    edit.visible = visible;
  else if (name != layer->name)
    edit.name = name;
  else
    return;
  // The list is made again, which is not possible while it emits a signal.
  QMetaObject::invokeMethod(
      this,
      [this, edit] {
        if (!workbench_.apply(edit)) refresh();
      },
      Qt::QueuedConnection);
}

void LayerPanel::set_opacity(int percent) {
  const LayerItem* const layer = active();
  if (!layer) return;
  EditLayer edit{layer->id};
  edit.opacity = static_cast<float>(percent) / 100;
  edit.continues = opacity_->isSliderDown() && std::exchange(opacity_dragged_, true);
  workbench_.apply(edit);
}

// A box shows a rounded value: only the one that was edited changes the layer.
void LayerPanel::set_contrast() {
  const LayerItem* const layer = active();
  if (!layer) return;
  EditLayer edit{layer->id};
  if (sender() == window_)
    edit.window = window_->value();
  else
    edit.level = level_->value();
  workbench_.apply(edit);
}

QString LayerPanel::transform_text(const LayerItem& layer) const {
  const LayerImages& images = workbench_.layer_images();
  LayerItem source = layer;
  source.preprocessing = {};
  if (!images.image_of(layer) && images.image_of(source))
    return tr("Not shown: its filters could not be computed. Restore the installation and open the scene again.");
  if (!images.image_of(layer))
    return tr("Not shown: the image '%1' could not be read. Restore the file and open the scene again.")
        .arg(text(layer.path));
  if (!images.has_transform(layer))
    return tr("Not shown: the transform '%1' could not be read. Restore the file and open the scene again.")
        .arg(text(layer.transform.file));
  if (layer.transform.is_identity()) return tr("Transform: none, the positions of the files are used");
  const Eigen::Matrix3d linear = layer.transform.affine.linear();
  const double degrees =
      std::acos(std::clamp((nearest_rotation(linear).trace() - 1) / 2, -1.0, 1.0)) * 180 / std::numbers::pi;
  const bool rigid = (linear * linear.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-6;
  // At the centre of the volume, because the translation of the matrix depends on the origin.
  const Eigen::Vector3d centre = workbench_.session().volume().geometry().centre_mm();
  const double shift_mm = (layer.transform.affine * centre - centre).norm();
  QString matrix = tr("%1, rotation %2\u00b0, shift %3 mm at the centre")
                       .arg(rigid ? tr("rigid") : tr("affine"))
                       .arg(degrees, 0, 'f', 1)
                       .arg(shift_mm, 0, 'f', 1);
  if (layer.transform.file.empty()) return tr("Transform: %1").arg(matrix);
  return tr("Transform: displacement field %1, then %2").arg(QFileInfo(text(layer.transform.file)).fileName(), matrix);
}

void LayerPanel::refresh() {
  const QSignalBlocker list(list_), colours(colours_), opacity(opacity_), window(window_), level(level_);
  list_->clear();
  for (const LayerItem& layer : workbench_.scene().layers) {
    auto* row = new QTreeWidgetItem(list_, {text(layer.name), tr(info_of(layer.colour_map).title)});
    row->setData(0, Qt::UserRole, layer.id);
    row->setCheckState(0, layer.visible ? Qt::Checked : Qt::Unchecked);
    row->setFlags(row->flags() | Qt::ItemIsEditable);
    row->setToolTip(0, text(layer.path));
    if (layer.id == workbench_.view.active_layer) list_->setCurrentItem(row);
  }
  const LayerItem* const layer = active();
  for (QWidget* control : {static_cast<QWidget*>(colours_), static_cast<QWidget*>(opacity_),
                           static_cast<QWidget*>(window_), static_cast<QWidget*>(level_)})
    set_enabled(control, layer != nullptr, tr("Add a layer first"));
  const auto show_filters = [](QLabel* label, const QString& what, const std::vector<FilterStep>& filters) {
    label->setText(filters.empty() ? QString() : QString("%1: %2").arg(what, text(describe(filters))));
    label->setVisible(!filters.empty());
  };
  show_filters(filters_, tr("Filters"), layer ? layer->preprocessing.filters : std::vector<FilterStep>());
  show_filters(volume_, tr("Filters of the volume"), workbench_.scene().volume_preprocessing.filters);
  transform_->setText(layer ? transform_text(*layer) : QString());
  percent_->setText(layer ? QString("%1%").arg(std::lround(layer->opacity * 100)) : QString());
  unit_->setText(layer ? text(layer->unit) : QString());
  if (!layer) return;
  colours_->setCurrentIndex(static_cast<int>(layer->colour_map));
  opacity_->setValue(static_cast<int>(std::lround(layer->opacity * 100)));
  const int decimals = std::clamp(3 - static_cast<int>(std::floor(std::log10(layer->window))), 0, 9);
  window_->setDecimals(decimals);
  level_->setDecimals(decimals);
  window_->setValue(layer->window);
  level_->setValue(layer->level);
}

}  // namespace simplexseg
