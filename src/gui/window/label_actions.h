// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QString>
#include <memory>
#include <vector>

#include "io/labels/label_mesh.h"

class QWidget;

namespace simplexseg {

class ActionTable;
class BackgroundJob;
class FileActions;
class Workbench;

/// Imports labels and meshes of other programs, as new meshes or as references. Files are read in the background.
class LabelActions : public QObject {
  Q_OBJECT
 public:
  LabelActions(Workbench& workbench, BackgroundJob& job, FileActions& files, ActionTable& actions, QWidget& window);

  /// Reads labels and lets the user choose some of them; each chosen label becomes a mesh.
  void meshes_from_labels(const QString& path);
  /// Adds a mesh whose initial surface is read from a file.
  void mesh_from_file(const QString& path);
  /// Reads reference labels and assigns to each mesh the label with the largest overlap; each label is assigned to at
  /// most one mesh.
  void load_reference(const QString& path);

 private:
  struct Labels;
  void choose_labels(const QString& path, const std::shared_ptr<Labels>& labels);
  void make_meshes(const QString& path, const std::shared_ptr<Labels>& labels, const std::vector<LabelCount>& chosen);
  void show_with_warnings(QString text, const std::vector<std::string>& warnings);
  void enable_actions();

  Workbench& workbench_;
  BackgroundJob& job_;
  FileActions& files_;
  ActionTable& actions_;
  QWidget& window_;
};

}  // namespace simplexseg
