// SPDX-License-Identifier: Apache-2.0
#include "gui/window/series_dialog.h"

#include <QDialogButtonBox>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QLabel>
#include <QPainter>
#include <QPushButton>
#include <QSpinBox>
#include <QTreeWidget>
#include <QVBoxLayout>
#include <algorithm>

#include "gui/look/contrast.h"
#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"

namespace simplexseg {
namespace {

constexpr int kIconPixels = 64;  // side of an icon, logical pixels
enum SeriesColumn { kSeries, kPatient, kStudy, kModality, kSize, kSpacing, kColumns };

/// Icon of the previewed slice in grey, with the proportions of the slice in mm; dark without a preview.
QIcon picture_of(const Volume& preview) {
  QPixmap pixmap(kIconPixels, kIconPixels);
  pixmap.fill(theme::kSliceBackground);
  if (preview.empty()) return QIcon(pixmap);
  const Volume::Range range = contrast_range(preview);
  const auto [ni, nj, nk] = preview.geometry().size;
  QImage image(ni, nj, QImage::Format_Grayscale8);
  for (int j = 0; j < nj; ++j)
    for (int i = 0; i < ni; ++i) {
      const double grey = 255 * (preview.value(i, j, 0) - range.min) / (range.max - range.min);
      image.scanLine(j)[i] = static_cast<uchar>(grey >= 0 ? std::min(grey, 255.0) : 0);  // NaN: black
    }
  const Eigen::Vector3d mm = preview.geometry().spacing_mm;
  const double scale = kIconPixels / std::max(ni * mm[0], nj * mm[1]);
  const QSizeF size(ni * mm[0] * scale, nj * mm[1] * scale);
  QPainter painter(&pixmap);
  painter.setRenderHint(QPainter::SmoothPixmapTransform);
  painter.drawImage(QRectF(QPointF((kIconPixels - size.width()) / 2, (kIconPixels - size.height()) / 2), size), image);
  return QIcon(pixmap);
}

}  // namespace

SeriesDialog::SeriesDialog(FoundSeries found, QWidget* parent)
    : QDialog(parent),
      found_(std::move(found)),
      list_(new QTreeWidget(this)),
      details_(new QLabel(this)),
      volume_row_(new QWidget(this)),
      volume_(new QSpinBox(volume_row_)),
      open_(nullptr) {
  setObjectName("series_dialog");
  setWindowTitle(tr("Open a DICOM series"));
  resize(std::min(940, parent ? parent->width() - 24 : 940), std::min(520, parent ? parent->height() - 40 : 520));
  list_->setAccessibleName(tr("Series"));
  list_->setHeaderLabels({tr("Series"), tr("Patient"), tr("Study"), tr("Modality"), tr("Size"), tr("Spacing (mm)")});
  list_->setRootIsDecorated(false);
  list_->setIconSize({kIconPixels, kIconPixels});
  list_->setAllColumnsShowFocus(true);
  for (const DicomSeries& series : found_.series) add(series);
  list_->header()->setStretchLastSection(true);
  list_->setColumnWidth(kSeries, 300);
  for (const int column : {kPatient, kStudy, kModality, kSize}) list_->resizeColumnToContents(column);
  for (const int column : {kPatient, kStudy}) list_->setColumnWidth(column, std::min(150, list_->columnWidth(column)));
  details_->setWordWrap(true);
  details_->setTextFormat(Qt::PlainText);
  details_->setMinimumHeight(3 * details_->fontMetrics().lineSpacing());
  details_->setAlignment(Qt::AlignLeft | Qt::AlignTop);
  details_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  auto* volume_row = new QHBoxLayout(volume_row_);
  volume_row->setContentsMargins(0, 0, 0, 0);
  auto* volume_label = new QLabel(tr("&Volume of the 4D series:"), volume_row_);
  volume_label->setBuddy(volume_);
  volume_row->addWidget(volume_label);
  volume_row->addWidget(volume_);
  volume_row->addStretch(1);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Open | QDialogButtonBox::Cancel, this);
  open_ = buttons->button(QDialogButtonBox::Open);
  open_->setDefault(true);
  auto* column = new QVBoxLayout(this);
  column->addWidget(list_, 1);
  column->addWidget(volume_row_);
  column->addWidget(details_);
  if (!found_.unreadable.empty()) {
    const auto count = static_cast<int>(found_.unreadable.size());
    const QString first = text(found_.unreadable.front());
    auto* unreadable = new QLabel(count == 1 ? tr("1 file cannot be read: %1").arg(first)
                                             : tr("%1 files cannot be read; the first is %2").arg(count).arg(first),
                                  this);
    QStringList all;
    for (std::size_t n = 0; n < found_.unreadable.size() && n < 30; ++n) all << text(found_.unreadable[n]);
    unreadable->setToolTip(all.join('\n'));
    unreadable->setWordWrap(true);
    set_role(unreadable, "warning");
    column->addWidget(unreadable);
  }
  column->addWidget(buttons);
  connect(buttons, &QDialogButtonBox::accepted, this, &QDialog::accept);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  connect(list_, &QTreeWidget::currentItemChanged, this, &SeriesDialog::refresh);
  connect(list_, &QTreeWidget::itemActivated, this, [this] {
    if (open_->isEnabled()) accept();
  });
  // Preselects the largest readable series.
  int best = 0;
  for (std::size_t n = 1; n < found_.series.size(); ++n) {
    const DicomSeries &one = found_.series[n], &other = found_.series[static_cast<std::size_t>(best)];
    if (std::pair(one.load_error.empty(), one.geometry.voxel_count()) >
        std::pair(other.load_error.empty(), other.geometry.voxel_count()))
      best = static_cast<int>(n);
  }
  list_->setCurrentItem(list_->topLevelItem(best));
  refresh();
}

void SeriesDialog::add(const DicomSeries& series) {
  auto* item = new QTreeWidgetItem(list_);
  const QString name = series.texts.series.empty() ? tr("(no description)") : text(series.texts.series);
  QString state;
  if (!series.load_error.empty())
    state = tr("cannot be opened");
  else if (series.damaged)
    state = tr("damaged: can be opened in part");
  else if (series.volumes > 1)
    state = tr("4D: %1 volumes").arg(series.volumes);
  item->setText(kSeries, state.isEmpty() ? name : name + '\n' + state);
  item->setIcon(kSeries, picture_of(series.preview));
  item->setToolTip(kSeries, tr("%1 in %2").arg(counted_text(series.files, "file"), text(series.folder)));
  item->setText(kPatient, text(series.texts.patient) +
                              (series.texts.patient_id.empty() ? QString() : '\n' + text(series.texts.patient_id)));
  item->setText(kStudy, text(series.texts.study) + '\n' + text(series.texts.date));
  item->setText(kModality, text(series.texts.modality));
  if (series.load_error.empty()) {
    const auto [ni, nj, nk] = series.geometry.size;
    item->setText(kSize, tr("%1\n%2 x %3").arg(counted_text(nk, "slice")).arg(ni).arg(nj));
    const Eigen::Vector3d mm = series.geometry.spacing_mm;
    item->setText(kSpacing, tr("%1\n%2 x %3").arg(mm[2], 0, 'g', 4).arg(mm[0], 0, 'g', 4).arg(mm[1], 0, 'g', 4));
  } else {
    item->setText(kSize, counted_text(series.files, "file"));
  }
  if (!series.load_error.empty() || series.damaged) item->setForeground(kSeries, theme::shades().warning);
}

const DicomSeries* SeriesDialog::chosen() const {
  const int at = list_->indexOfTopLevelItem(list_->currentItem());
  return at < 0 ? nullptr : &found_.series[static_cast<std::size_t>(at)];
}

int SeriesDialog::volume() const { return volume_->value(); }

void SeriesDialog::refresh() {
  const DicomSeries* series = chosen();
  volume_->setRange(1, series ? series->volumes : 1);
  volume_->setSuffix(tr(" of %1").arg(volume_->maximum()));
  volume_row_->setVisible(volume_->maximum() > 1);
  const bool opens = series && series->load_error.empty();
  set_enabled(open_, opens, series ? text(series->load_error) : tr("Select a series first"));
  QStringList lines;
  if (series && !opens) lines << tr("This series cannot be opened: %1").arg(text(series->load_error));
  if (series)
    for (const std::string& warning : series->warnings) lines << text(warning);
  details_->setText(lines.join('\n'));
  set_role(details_, lines.isEmpty() ? "dim" : "warning");
}

}  // namespace simplexseg
