// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QString>
#include <memory>
#include <vector>

#include "io/label_mesh.h"

class QWidget;

namespace simplexseg {

class ActionTable;
class BackgroundJob;
class FileActions;
class Workbench;

/// What is done with labels and meshes of other programs: meshes are made from them, and compared with them. Files are
/// read in the background.
class LabelActions : public QObject {
  Q_OBJECT
 public:
  LabelActions(Workbench& workbench, BackgroundJob& job, FileActions& files, ActionTable& actions, QWidget& window);

  /// Reads labels, and lets the user choose among them; each that is chosen becomes a mesh.
  void meshes_from_labels(const QString& path);
  /// A mesh that starts as the surface in a file.
  void mesh_from_file(const QString& path);
  /// Reads labels; each mesh is compared with the one that it overlaps most, of those that no other mesh has more of.
  void load_reference(const QString& path);

 private:
  struct Labels;
  void choose_labels(const QString& path, const std::shared_ptr<Labels>& labels);
  void make_meshes(const QString& path, const std::shared_ptr<Labels>& labels, const std::vector<LabelCount>& chosen);
  void say_with_warnings(QString text, const std::vector<std::string>& warnings);
  void enable_actions();

  Workbench& workbench_;
  BackgroundJob& job_;
  FileActions& files_;
  ActionTable& actions_;
  QWidget& window_;
};

}  // namespace simplexseg
