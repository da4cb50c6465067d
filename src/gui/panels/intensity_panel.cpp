// SPDX-License-Identifier: Apache-2.0
#include "gui/panels/intensity_panel.h"

#include <QAction>
#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QSignalBlocker>
#include <QToolButton>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>

#include "gui/input/action_table.h"
#include "gui/look/number_box.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "gui/panels/intensity_plot.h"
#include "gui/workbench/workbench.h"
#include "session/step_messages.h"

namespace simplexseg {
namespace {

constexpr int kIntervals = 128;

/// Histogram of the intensities at the centres of the cells of an object, at most about 300,000, in given intervals.
std::vector<std::size_t> counts_in_object(const MeshField& field, const Volume& volume,
                                          const IntensityHistogram& histogram) {
  constexpr std::size_t kMostCells = 300'000;
  const std::vector<std::uint8_t> object = field.object_cells();
  const auto inside = static_cast<std::size_t>(std::ranges::count(object, std::uint8_t{1}));
  const std::size_t step = inside / kMostCells + 1;
  std::vector<std::size_t> counts(histogram.counts.size(), 0);
  std::size_t seen = 0;
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> voxels = volume.voxels<T>();
    for (std::size_t cell = 0; cell < object.size(); ++cell) {
      if (!object[cell] || seen++ % step != 0) continue;
      const int size_i = field.box.size[0], size_j = field.box.size[1], c = static_cast<int>(cell);
      const std::array<int, 3> in_box{c % size_i, c / size_i % size_j, c / size_i / size_j};
      std::array<int, 3> at;
      for (int a = 0; a < 3; ++a)
        at[a] = std::min(static_cast<int>((field.box.first[a] + in_box[a] + 0.5) * field.cell[a]),
                         volume.geometry().size[a] - 1);
      const auto value = static_cast<double>(voxels[volume.offset(at[0], at[1], at[2])]);
      if (std::isfinite(value)) ++counts[histogram.interval_of(value)];
    }
  });
  return counts;
}

}  // namespace

/// Field for a limit of a range, which can be absent.
class LimitBox : public NumberBox {
 public:
  LimitBox(QWidget* parent, double absent) : NumberBox(parent), absent_(absent) {
    setRange(-kLargest, kLargest);
    setKeyboardTracking(false);
  }
  void show_limit(double limit) { setValue(std::isfinite(limit) ? limit : std::copysign(kLargest, absent_)); }
  double limit() const { return std::abs(value()) >= kLargest ? absent_ : value(); }
  /// Intensity from which a step leads if there is no limit.
  void set_start(double start) { start_ = start; }

 protected:
  QString textFromValue(double value) const override {
    return std::abs(value) >= kLargest ? tr("none") : NumberBox::textFromValue(value);
  }
  double valueFromText(const QString& text) const override {
    return text.trimmed() == tr("none") ? std::copysign(kLargest, absent_) : NumberBox::valueFromText(text);
  }
  QValidator::State validate(QString& text, int& position) const override {
    if (text == tr("none")) return QValidator::Acceptable;
    return tr("none").startsWith(text) ? QValidator::Intermediate : NumberBox::validate(text, position);
  }
  StepEnabled stepEnabled() const override { return StepUpEnabled | StepDownEnabled; }
  void stepBy(int steps) override {
    if (std::abs(value()) >= kLargest)
      setValue(start_);
    else
      NumberBox::stepBy(steps);
  }

 private:
  static constexpr double kLargest = 1e9;
  double absent_, start_ = 0;
};

IntensityPanel::IntensityPanel(Workbench& workbench, ActionTable& actions, QWidget* parent)
    : QWidget(parent),
      workbench_(workbench),
      plot_(new IntensityPlot(this)),
      low_(new LimitBox(this, IntensityRange{}.low)),
      high_(new LimitBox(this, IntensityRange{}.high)),
      remove_(new QPushButton(tr("No limits"), this)),
      title_(new QLabel(this)),
      hint_(new QLabel(this)) {
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(8, 6, 8, 6);
  layout->addWidget(title_);
  layout->addWidget(plot_, 1);
  auto* limits = new QHBoxLayout;
  limits->addWidget(new QLabel(tr("From"), this));
  limits->addWidget(low_, 1);
  limits->addWidget(new QLabel(tr("to"), this));
  limits->addWidget(high_, 1);
  layout->addLayout(limits);
  low_->setAccessibleName(tr("Lower limit of the intensity"));
  high_->setAccessibleName(tr("Upper limit of the intensity"));
  low_->setToolTip(tr("Darker tissue does not belong to the segmentation"));
  high_->setToolTip(tr("Brighter tissue does not belong to the segmentation"));
  auto* buttons = new QHBoxLayout;
  auto* sample = new QToolButton(this);
  sample->setDefaultAction(actions[Act::ToolRange]);
  actions[Act::ToolRange]->setIconText(tr("Sample tissue"));
  sample->setToolButtonStyle(Qt::ToolButtonTextBesideIcon);
  buttons->addWidget(sample);
  buttons->addStretch(1);
  remove_->setToolTip(tr("Allow all intensities"));
  buttons->addWidget(remove_);
  layout->addLayout(buttons);
  hint_->setWordWrap(true);
  layout->addWidget(hint_);
  connect(plot_, &IntensityPlot::dragged, this, [this] {
    if (!workbench_.view.range_preview) dragged_mesh_ = workbench_.view.active_mesh;
    show_limits(plot_->range());
    workbench_.view.range_preview = plot_->range();
    workbench_.view_edited();
  });
  connect(plot_, &IntensityPlot::dropped, this, [this] {
    const IntensityRange range = plot_->range();  // view_edited() shows that of the mesh
    workbench_.view.range_preview.reset();
    workbench_.view_edited();
    if (dragged_mesh_ == workbench_.view.active_mesh) apply(range);
  });
  connect(plot_, &IntensityPlot::cancelled, this, [this] {
    workbench_.view.range_preview.reset();
    workbench_.view_edited();
  });
  // Only the limit that was edited changes: the other field shows a rounded value.
  connect(low_, &QDoubleSpinBox::valueChanged, this, [this] { apply({low_->limit(), plot_->range().high}); });
  connect(high_, &QDoubleSpinBox::valueChanged, this, [this] { apply({plot_->range().low, high_->limit()}); });
  connect(remove_, &QPushButton::clicked, this, [this] { apply({}); });
  for (const auto signal : {&Workbench::scene_changed, &Workbench::view_changed, &Workbench::volume_changed})
    connect(&workbench_, signal, this, &IntensityPanel::refresh);
  connect(&workbench_, &Workbench::advanced, this, [this] {
    const MeshItem* const item = workbench_.active_mesh();
    if (item && item->has_field() && item->field != object_) refresh();
  });
  refresh();
}

void IntensityPanel::showEvent(QShowEvent* event) {
  QWidget::showEvent(event);
  refresh();
}

void IntensityPanel::show_limits(const IntensityRange& range) {
  const QSignalBlocker low(low_), high(high_);
  low_->show_limit(range.low);
  high_->show_limit(range.high);
}

void IntensityPanel::apply(const IntensityRange& range) {
  const MeshItem* const item = workbench_.active_mesh();
  if (!item || range == item->intensity_range) return;
  if (!workbench_.apply(SetIntensityRange{item->id, range})) refresh();
}

void IntensityPanel::refresh_histograms() {
  const Volume& volume = workbench_.session().volume();
  const void* const voxels = workbench_.has_volume() ? volume.data() : nullptr;
  if (std::exchange(voxels_, voxels) != voxels) {
    const IntensityHistogram histogram = voxels ? histogram_of(volume, kIntervals) : IntensityHistogram{};
    const double span = histogram.range.high - histogram.range.low;
    for (LimitBox* box : {low_, high_}) {
      const QSignalBlocker blocker(box);
      box->setDecimals(std::isfinite(span) ? std::clamp(3 - static_cast<int>(std::floor(std::log10(span))), 0, 15) : 0);
      box->setSingleStep(std::isfinite(span) ? std::pow(10.0, std::floor(std::log10(span / 50))) : 1);
    }
    low_->set_start(histogram.range.low);
    high_->set_start(histogram.range.high);
    plot_->show_histogram(histogram);
    object_.reset();
  }
  const MeshItem* const item = workbench_.active_mesh();
  std::shared_ptr<const MeshField> field = voxels && item && item->has_field() ? item->field : nullptr;
  if (std::exchange(object_, field) == field) return;
  if (field && !plot_->histogram().counts.empty())
    plot_->show_object(counts_in_object(*field, volume, plot_->histogram()),
                       QColor(item->colour.red, item->colour.green, item->colour.blue));
  else
    plot_->show_object({}, {});
}

void IntensityPanel::refresh() {
  if (!isVisible() || workbench_.is_dragging()) return;
  refresh_histograms();
  const MeshItem* const item = workbench_.active_mesh();
  const QString why_not = !workbench_.has_volume() ? tr("Open a volume first")
                          : !item                  ? tr("Place a seed first")
                          : item->locked           ? tr("Unlock the segmentation first")
                          : item->is_given() ? tr("A segmentation from labels or a mesh does not depend on the image")
                                             : QString();
  for (QWidget* control : {static_cast<QWidget*>(plot_), static_cast<QWidget*>(low_), static_cast<QWidget*>(high_)})
    set_enabled(control, why_not.isEmpty(), why_not);
  set_enabled(remove_, why_not.isEmpty() && item->intensity_range.is_limited(),
              why_not.isEmpty() ? tr("There are no limits") : why_not);
  const QString unit = text(workbench_.intensity_unit());
  title_->setText(!item            ? tr("Range of intensities")
                  : unit.isEmpty() ? tr("Range of intensities of %1").arg(text(item->name))
                                   : tr("Range of intensities of %1, %2").arg(text(item->name), unit));
  const IntensityRange range = item ? item->intensity_range : IntensityRange{};
  const MeshField* const field = item ? item->field.get() : nullptr;
  const std::string warning =
      field && field->intensity_range == range ? range_warning(item->name, field->range_effect) : std::string();
  set_role(hint_, warning.empty() ? "dim" : "warning");
  hint_->setText(!warning.empty() ? text(warning)
                                  : tr("Only tissue with these intensities belongs to the segmentation, except where "
                                       "it is marked or painted. Enclosed spots are filled."));
  plot_->show_range(range);
  if (!workbench_.view.range_preview) show_limits(range);
}

}  // namespace simplexseg
