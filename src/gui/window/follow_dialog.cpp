// SPDX-License-Identifier: Apache-2.0
#include "gui/window/follow_dialog.h"

#include <QCheckBox>
#include <QComboBox>
#include <QDialogButtonBox>
#include <QFileDialog>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QMessageBox>
#include <QPushButton>
#include <QVBoxLayout>
#include <utility>

#include "core/error.h"
#include "gui/look/integer_box.h"
#include "gui/look/number_box.h"
#include "gui/look/qt_text.h"
#include "gui/look/widgets.h"
#include "io/platform/output_checks.h"
#include "io/source/volume_info.h"
#include "io/transform/transform_io.h"

namespace simplexseg {
namespace {
enum Registration : int { kRigid, kAffine, kField, kNone, kFile };
constexpr double kAutomatic = -1;  ///< expected error that depends on the registration
const char* kImageFilter =
    "Volumes (*.nii *.nii.gz *.hdr *.img *.nrrd *.nhdr *.mha *.mhd *.gipl *.gipl.gz *.mnc *.dcm);;All files (*)";
const char* kTransformFilter = "Transforms (*.tfm *.txt *.mat *.h5 *.nii *.nii.gz);;All files (*)";
}  // namespace

FollowDialog::FollowDialog(Kind kind, Defaults defaults, QWidget* parent)
    : QDialog(parent), kind_(kind), defaults_(std::move(defaults)), form_(new QFormLayout) {
  const bool time_points = kind_ == Kind::TimePoints;
  setObjectName("follow_dialog");
  setWindowTitle(time_points ? tr("Follow time points") : tr("Carry over to the next study"));
  auto* column = new QVBoxLayout(this);
  auto* hint = new QLabel(
      time_points ? tr("Carries the segmentations to the other volumes of a 4D image and shows the course of their "
                       "volumes. Always compare the scenes with their images.")
                  : tr("Registers the next study to this one and carries surfaces, marks and locks over, where they "
                       "settle. The open scene stays as it is in its file. Always compare the result with the image."),
      this);
  hint->setWordWrap(true);
  column->addWidget(hint);
  column->addLayout(form_);
  image_ = add_path(time_points ? tr("&4D image:") : tr("&Next study:"), "follow_image", defaults_.image);
  const auto folder = [this] { return url_of(defaults_.folder); };
  add_button(image_, tr("&File..."), "choose_follow_file", [=, this] {
    return local_path(QFileDialog::getOpenFileUrl(this, time_points ? tr("4D image") : tr("Image of the next study"),
                                                  folder(), kImageFilter));
  });
  add_button(image_, tr("F&older..."), "choose_follow_folder", [=, this] {
    return local_path(QFileDialog::getExistingDirectoryUrl(this, tr("DICOM folder of the next study"), folder()));
  });
  if (!time_points) {
    volume_ = new IntegerBox(this);
    volume_->setObjectName("follow_volume");
    volume_->setRange(1, kMaxVolumes);
    volume_->setToolTip(tr("Number of the volume in a 4D file or series"));
    form_->addRow(tr("&Volume of a 4D file:"), volume_);
  }
  add_registration();
  output_ =
      add_path(time_points ? tr("&Scenes in folder:") : tr("&Save the scene as:"), "follow_output", defaults_.output);
  add_button(output_, tr("&Choose..."), "choose_follow_output", [=, this] {
    return local_path(
        time_points
            ? QFileDialog::getExistingDirectoryUrl(this, tr("Folder of the scenes"), url_of(output_.field->text()))
            : QFileDialog::getSaveFileUrl(this, tr("Scene of the next study"), url_of(output_.field->text()),
                                          tr("Scenes (*.json)"), nullptr, QFileDialog::DontConfirmOverwrite));
  });
  message_ = new QLabel(this);
  message_->setObjectName("follow_message");
  message_->setWordWrap(true);
  set_role(message_, "warning");
  message_->hide();
  column->addWidget(message_);
  column->addStretch();
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel, this);
  buttons->button(QDialogButtonBox::Ok)->setText(time_points ? tr("&Follow") : tr("Carry &over"));
  buttons->button(QDialogButtonBox::Ok)->setDefault(true);
  column->addWidget(buttons);
  connect(buttons, &QDialogButtonBox::accepted, this, &QDialog::accept);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  refresh();
  resize(600, sizeHint().height());
  fit_on_screen(*this);
}

FollowDialog::PathRow FollowDialog::add_path(const QString& title, const char* name, const QString& text) {
  const PathRow path{new QLineEdit(text, this), new QHBoxLayout};
  path.field->setObjectName(name);
  path.row->addWidget(path.field, 1);
  auto* label = new QLabel(title, this);
  label->setBuddy(path.field);
  form_->addRow(label, path.row);
  return path;
}

void FollowDialog::add_button(const PathRow& path, const QString& title, const char* name,
                              const std::function<QString()>& ask) {
  auto* button = new QPushButton(title, this);
  button->setObjectName(name);
  button->setAutoDefault(false);
  connect(button, &QPushButton::clicked, this, [field = path.field, ask] {
    if (const QString chosen = ask(); !chosen.isEmpty()) field->setText(chosen);
  });
  path.row->addWidget(button);
}

void FollowDialog::add_registration() {
  const bool time_points = kind_ == Kind::TimePoints;
  registration_ = new QComboBox(this);
  registration_->setObjectName("follow_registration");
  registration_->addItem(tr("none: positions in the files"), kNone);
  registration_->addItem(tr("rigid: rotation and translation"), kRigid);
  registration_->addItem(tr("affine: with scales and shears"), kAffine);
  registration_->addItem(tr("displacement field: takes minutes"), kField);
  if (!time_points) registration_->addItem(tr("transform of a file"), kFile);
  registration_->setCurrentIndex(registration_->findData(time_points ? kField : kRigid));
  form_->addRow(tr("&Registration:"), registration_);
  note_ = new QLabel(this);
  note_->setWordWrap(true);
  set_role(note_, "dim");
  form_->addRow(note_);
  if (!time_points) {
    transform_ = add_path(tr("&Transform:"), "follow_transform", {});
    transform_.field->setToolTip(
        tr("Transform from points of this study to points of the next one, of ITK, ANTs, 3D Slicer "
           "or elastix"));
    add_button(transform_, tr("Choose..."), "choose_follow_transform", [this] {
      return local_path(QFileDialog::getOpenFileUrl(this, tr("Transform to the next study"), url_of(defaults_.folder),
                                                    kTransformFilter));
    });
  }
  marks_ = new QComboBox(this);
  marks_->setObjectName("follow_marks");
  marks_->addItem(tr("those at which the images agree"), static_cast<int>(CarriedMarks::Agreeing));
  marks_->addItem(tr("all"), static_cast<int>(CarriedMarks::All));
  marks_->addItem(tr("none"), static_cast<int>(CarriedMarks::None));
  form_->addRow(tr("&Marks:"), marks_);
  error_ = new NumberBox(this);
  error_->setObjectName("follow_error");
  error_->setRange(kAutomatic, kMaxErrorMm);
  error_->setValue(kAutomatic);
  error_->setSpecialValueText(tr("automatic"));
  error_->setSuffix(tr(" mm"));
  connect(error_, &QDoubleSpinBox::valueChanged, this, [this](double mm) {
    if (mm < 0) error_->setValue(kAutomatic);
    refresh();
  });
  error_->setToolTip(
      tr("Expected error of the carried surfaces (standard deviation): a larger value lets objects "
         "change more. 0: exactly as carried"));
  form_->addRow(tr("&Expected error:"), error_);
  if (!time_points) {
    layer_ = new QCheckBox(tr("Show this study as a &layer of the next one"), this);
    layer_->setObjectName("follow_layer");
    layer_->setChecked(true);
    form_->addRow(layer_);
  }
  connect(registration_, &QComboBox::currentIndexChanged, this, &FollowDialog::refresh);
}

void FollowDialog::refresh() {
  const int kind = registration_->currentData().toInt();
  note_->setText(kind == kRigid    ? tr("Two scans of one patient's head, or of a part that does not bend.")
                 : kind == kAffine ? tr("Scanners with distortion, or other positions of the patient.")
                 : kind == kField && kind_ == Kind::TimePoints
                     ? tr("Beating or breathing organs. The surfaces are those of this volume, moved by the field.")
                 : kind == kField ? tr("Organs that have moved: breathing, filling, growth.")
                 : kind == kNone && kind_ == Kind::TimePoints
                     ? tr("Each volume is carried to its neighbour and settles there. Errors add up.")
                 : kind == kNone ? tr("Images whose positions agree already.")
                                 : tr("A registration of another program."));
  const bool unmarked = kind_ == Kind::TimePoints && kind == kField && error_->value() < 0;
  set_enabled(marks_, !unmarked, tr("The surfaces are exactly those of the field; with an expected error, marks act"));
  if (transform_.row) form_->setRowVisible(transform_.row, kind == kFile);
}

FollowDialog::Choice FollowDialog::choice() const {
  Choice chosen;
  if (image_.field->text().isEmpty())
    throw Error("no image", "the image to follow is missing", "choose a file or a DICOM folder");
  if (!path_exists(image_.field->text()))
    throw Error("'" + shown_path(image_.field->text()) + "'", "file not found", "choose a file or a DICOM folder");
  if (output_.field->text().isEmpty())
    throw Error("no output", "the place of the new scene is missing", "choose where to save it");
  chosen.image.path = to_path(image_.field->text()).string();
  if (volume_) chosen.image.number = volume_->value();
  const int registration = registration_->currentData().toInt();
  if (registration <= kField) chosen.settings.kind = static_cast<RegistrationKind>(registration);
  if (registration == kFile) chosen.settings.transform.append(read_transform(to_path(transform_.field->text())));
  if (error_->value() >= 0) chosen.settings.error_mm = error_->value();
  chosen.settings.marks = static_cast<CarriedMarks>(marks_->currentData().toInt());
  chosen.earlier_layer = layer_ && layer_->isChecked();
  chosen.output = to_path(output_.field->text());
  OutputChecks checks(defaults_.used);
  checks.add_input(chosen.image.path);
  if (kind_ == Kind::TimePoints) {
    checks.require_folder(chosen.output);
  } else {
    if (chosen.output.extension() != ".json") chosen.output += ".json";
    checks.require_file(chosen.output);
  }
  return chosen;
}

bool FollowDialog::may_replace(const std::filesystem::path& output) {
  std::error_code failure;
  const bool used = kind_ == Kind::TimePoints ? !std::filesystem::is_empty(output, failure) && !failure
                                              : std::filesystem::exists(output, failure);
  if (!used) return true;
  const QString name = text(output.filename());
  return QMessageBox::question(this, windowTitle(),
                               kind_ == Kind::TimePoints
                                   ? tr("The folder '%1' is not empty. Replace scenes with the same names?").arg(name)
                                   : tr("Replace the file '%1'?").arg(name)) == QMessageBox::Yes;
}

void FollowDialog::accept() {
  try {
    if (may_replace(choice().output)) QDialog::accept();
  } catch (const std::exception& error) {
    message_->setText(QString::fromUtf8(error.what()));
    message_->show();
  }
}

}  // namespace simplexseg
