// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <QString>
#include <filesystem>
#include <functional>
#include <vector>

#include "io/scene/follow_study.h"

class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QFormLayout;
class QHBoxLayout;
class QLabel;
class QLineEdit;
class QSpinBox;

namespace simplexseg {

/// Settings with which segmentations are carried over to the next study, or through the time points of a 4D image.
class FollowDialog : public QDialog {
  Q_OBJECT
 public:
  enum class Kind { NextStudy, TimePoints };
  /// Initial contents of the dialog.
  struct Defaults {
    QString folder;                           ///< of the file dialogs
    QString image;                            ///< of the time points; empty: none
    QString output;                           ///< scene of the next study, or folder of the time points
    std::vector<std::filesystem::path> used;  ///< files of the open study, which must not be replaced
  };
  struct Choice {
    FollowedImage image;
    FollowSettings settings;
    bool earlier_layer = false;
    std::filesystem::path output;
  };

  FollowDialog(Kind kind, Defaults defaults, QWidget* parent);
  /// Chosen settings. Throws Error for a missing image or output, a transform that cannot be read, or an output that
  /// cannot be written.
  Choice choice() const;
  /// Closes the dialog unless choice() throws, whose message is then shown.
  void accept() override;

 private:
  /// Row of the form with a path and the buttons that choose it.
  struct PathRow {
    QLineEdit* field = nullptr;
    QHBoxLayout* row = nullptr;
  };
  PathRow add_path(const QString& title, const char* name, const QString& text);
  void add_button(const PathRow& path, const QString& title, const char* name, const std::function<QString()>& ask);
  void add_registration();
  void refresh();
  bool may_replace(const std::filesystem::path& output);

  const Kind kind_;
  const Defaults defaults_;
  QFormLayout* form_;
  PathRow image_, output_, transform_;
  QSpinBox* volume_ = nullptr;
  QComboBox *registration_ = nullptr, *marks_ = nullptr;
  QDoubleSpinBox* error_ = nullptr;
  QCheckBox* layer_ = nullptr;
  QLabel *note_, *message_;
};

}  // namespace simplexseg
