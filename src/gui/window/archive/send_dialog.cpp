// SPDX-License-Identifier: Apache-2.0
#include "gui/window/archive/send_dialog.h"

#include <QCheckBox>
#include <QComboBox>
#include <QDialogButtonBox>
#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QVBoxLayout>
#include <algorithm>
#include <map>

#include "gui/input/key_map.h"
#include "gui/look/qt_text.h"
#include "gui/look/theme.h"
#include "gui/look/widgets.h"
#include "io/scene/measurement_export.h"
#include "io/scene/scene_export.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

constexpr int kPictureHeight = 220;  // largest height of the shown picture, logical pixels
constexpr const char *kContours = "contours.rtstruct.dcm", *kLabelMap = "labels.labelmap.dcm", *kView = "view.dcm";
// The report refers to the segments of this segmentation: save_measurements() writes both.
constexpr const char *kReport = "labels.sr.dcm", *kLabels = "labels.seg.dcm";

/// Index of the server from which the image was fetched; 0 if it was not fetched from any of them.
int server_of(const fs::path& image, const std::vector<ArchiveServer>& servers) {
  const std::string series = image.filename().string();
  if (!is_dicom_uid(series)) return 0;
  try {
    const ArchiveCache cache;
    for (std::size_t n = 0; n < servers.size(); ++n)
      if (cache.folder_of(servers[n], series) == image) return static_cast<int>(n);
  } catch (const std::exception&) {  // without a cache, nothing was fetched
  }
  return 0;
}

Picture picture_of(const QImage& image) {
  const QImage rgb = image.convertToFormat(QImage::Format_RGB888);
  Picture picture{rgb.width(), rgb.height(), {}};
  const std::size_t row = 3 * static_cast<std::size_t>(rgb.width());
  for (int y = 0; y < rgb.height(); ++y)
    picture.rgb.insert(picture.rgb.end(), rgb.constScanLine(y), rgb.constScanLine(y) + row);
  return picture;
}

}  // namespace

/// Files made from a scene, used by one thread at a time. Each file is made once, so that a file sent again after a
/// failure replaces the earlier copy in the archive.
struct SendDialog::OutgoingFiles {
  Scene scene;
  Volume volume;
  std::string unit;  ///< of the intensities
  Picture view;
  // The folder is readable by this user only, and is removed later even if the program is killed.
  ArchiveCache cache;
  IncomingSeries place{cache, {}};
  std::map<std::string, std::string> notes;  ///< warnings of the files made so far, by file name

  ArchiveSent send(const std::vector<std::string>& names, Archive& archive, const ArchiveProgress& progress) {
    std::vector<fs::path> files;
    if (std::ranges::find(names, kReport) != names.end() && !notes.contains(kReport)) {
      notes[kLabels] = save_measurements(place.folder() / kReport, scene, volume, unit);
      notes[kReport] = "";
    }
    for (const std::string& name : names) {
      files.push_back(place.folder() / name);
      if (notes.contains(name)) continue;
      std::string note;
      if (name == kView)
        save_view(files.back(), view, scene);
      else
        note = save_labels(files.back(), scene, volume.geometry());
      notes[name] = note;
    }
    ArchiveSent sent = archive.send(files, progress);
    for (const std::string& name : names)
      if (!notes[name].empty()) sent.warnings.push_back(notes[name]);
    return sent;
  }
};

SendDialog::SendDialog(Workbench& workbench, const QImage& picture, std::vector<ArchiveServer> servers,
                       BackgroundJob& job, const ArchiveOpener& open, QWidget* parent)
    : QDialog(parent),
      workbench_(workbench),
      picture_(picture),
      servers_(std::move(servers)),
      server_(new QComboBox(this)),
      task_(new ArchiveTask(job, open, tr("series already sent remain in the archive"), this)) {
  setObjectName("send_dialog");
  setWindowTitle(tr("Send to an archive"));
  auto* column = new QVBoxLayout(this);
  auto* note = new QLabel(tr("Each selected item becomes a new series in the study of the image."), this);
  note->setWordWrap(true);
  column->addWidget(note);
  auto* row = new QHBoxLayout;
  auto* label = new QLabel(tr("Archi&ve"), this);
  label->setBuddy(server_);
  server_->setObjectName("send_server");
  server_->setAccessibleName(tr("Archive"));
  for (const ArchiveServer& server : servers_)
    server_->addItem(tr("%1 (%2)").arg(text(server.name), text(address_of(server))));
  server_->setCurrentIndex(server_of(workbench_.scene().volume_path, servers_));
  row->addWidget(label);
  row->addWidget(server_, 1);
  column->addLayout(row);
  build_items(*column);
  auto* shown = new QLabel(this);
  shown->setAccessibleName(tr("Picture of the views"));
  shown->setPixmap(QPixmap::fromImage(picture_.scaled(theme::scaled(kPictureHeight * 2), theme::scaled(kPictureHeight),
                                                      Qt::KeepAspectRatio, Qt::SmoothTransformation)));
  column->addWidget(shown);
  column->addStretch(1);
  column->addWidget(task_);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close, this);
  send_ = buttons->addButton(tr("&Send"), QDialogButtonBox::ActionRole);
  send_->setObjectName("send_button");
  send_->setDefault(true);
  column->addWidget(buttons);
  connect(buttons, &QDialogButtonBox::rejected, this, &SendDialog::reject);
  connect(send_, &QPushButton::clicked, this, &SendDialog::send);
  for (QCheckBox* box : {labels_, contours_, report_, view_})
    connect(box, &QCheckBox::toggled, this, &SendDialog::refresh);
  connect(task_, &ArchiveTask::changed, this, &SendDialog::refresh);
  connect(task_, &ArchiveTask::cancelled, this, [this] { outgoing_.reset(); });  // the old thread still uses it
  resize(std::min(theme::scaled(560), parent->width() - 24), sizeHint().height());
  refresh();
}

void SendDialog::build_items(QVBoxLayout& column) {
  const bool meshes = !workbench_.scene().meshes.empty();
  const auto add = [&](const QString& title, const char* name, const QString& tip) {
    auto* box = new QCheckBox(title, this);
    box->setObjectName(name);
    box->setToolTip(tip);
    box->setChecked(meshes);
    column.addWidget(box);
    return box;
  };
  labels_ = add(tr("&Labels, as a segmentation (SEG)"), "send_labels", tr("Voxels inside each segmentation"));
  encoding_ = new QComboBox(this);
  encoding_->setObjectName("send_encoding");
  encoding_->addItem(tr("binary: a bit plane for each segmentation"), kLabels);
  encoding_->addItem(tr("label map: one image of label values"), kLabelMap);
  encoding_->setAccessibleName(tr("Encoding of the labels"));
  encoding_->setToolTip(tr("Most programs read binary segmentations; few read label maps yet"));
  auto* row = new QHBoxLayout;
  row->addSpacing(theme::scaled(24));
  row->addWidget(encoding_);
  row->addStretch(1);
  column.addLayout(row);
  contours_ = add(tr("C&ontours, as a structure set (RTSTRUCT)"), "send_contours",
                  tr("Contours of each segmentation in the slices; more precise than labels"));
  report_ = add(tr("&Measurements, as a structured report (SR) with its binary segmentation"), "send_report",
                tr("Volume, axes and intensities of each segmentation. The report refers to the binary segmentation, "
                   "which is sent with it"));
  report_->setChecked(false);
  view_ = add(tr("&Picture of the views (secondary capture)"), "send_view",
              tr("Picture shown below; %1 in the main window hides the patient's name").arg(key_hint(Act::Names)));
  for (QCheckBox* box : {labels_, contours_, report_}) set_enabled(box, meshes, tr("There is no segmentation yet"));
}

SendDialog::~SendDialog() = default;

void SendDialog::reject() {
  if (task_->busy())
    task_->cancel();
  else
    QDialog::reject();
}

void SendDialog::refresh() {
  set_enabled(encoding_, labels_->isChecked(), tr("No labels are selected"));
  const QString why = task_->busy()      ? tr("Wait for the running operation, or cancel it")
                      : servers_.empty() ? tr("Add an archive first: File > Archive")
                                         : tr("Select an item to send");
  set_enabled(send_, !chosen().empty() && !servers_.empty() && !task_->busy(), why);
}

std::vector<std::string> SendDialog::chosen() const {
  std::vector<std::string> names;
  if (report_->isChecked()) names = {kLabels, kReport};
  if (labels_->isChecked()) {
    const std::string labels = encoding_->currentData().toString().toStdString();
    if (std::ranges::find(names, labels) == names.end()) names.push_back(labels);
  }
  if (contours_->isChecked()) names.emplace_back(kContours);
  if (view_->isChecked()) names.emplace_back(kView);
  return names;
}

void SendDialog::send() {
  const ArchiveServer server = servers_[static_cast<std::size_t>(server_->currentIndex())];
  if (!outgoing_) {
    try {
      outgoing_ = std::make_shared<OutgoingFiles>();
    } catch (const std::exception& error) {
      task_->show_message(Severity::Failure, QString::fromUtf8(error.what()));
      return;
    }
    outgoing_->scene = workbench_.session().scene();
    outgoing_->volume = workbench_.session().volume();
    outgoing_->unit = workbench_.intensity_unit();
    outgoing_->view = picture_of(picture_);
  }
  auto sent = std::make_shared<ArchiveSent>();
  task_->start(
      tr("Sending"), server,
      [=, names = chosen(), outgoing = outgoing_](Archive& archive, const ArchiveProgress& progress) {
        *sent = outgoing->send(names, archive, progress);
      },
      [=, this] {
        QString result = sent->stored == 1 ? tr("Sent 1 series to %1").arg(text(server.name))
                                           : tr("Sent %1 series to %2").arg(sent->stored).arg(text(server.name));
        for (const std::string& warning : sent->warnings) result += "; " + text(warning);
        workbench_.notify(sent->warnings.empty() ? Severity::Note : Severity::Warning, result);
        accept();
      });
}

}  // namespace simplexseg
