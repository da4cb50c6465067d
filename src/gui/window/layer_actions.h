// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QMenu>
#include <QObject>
#include <QString>

#include "io/registration/registration.h"
#include "io/transform/landmarks.h"
#include "session/scene.h"

class QMainWindow;

namespace simplexseg {

class ActionTable;
class BackgroundJob;
class FileActions;
class Workbench;

/// Actions of layers, and their menu: adding images, registration, files of transforms, display. Files are read, and
/// images registered, in the background.
class LayerActions : public QObject {
  Q_OBJECT
 public:
  LayerActions(Workbench& workbench, BackgroundJob& job, FileActions& files, ActionTable& actions, QWidget& window);

  /// Entries of the menu Layers.
  void fill(QMenu& menu);
  /// Adds an image as a layer.
  void add(const QString& path);
  /// Registers a layer to the volume and sets its transform. `field_path`: file for the displacement field, required
  /// for that kind. `landmarks`: their residual after the registration is reported.
  void register_layer(ItemId id, const RegistrationSettings& settings, const QString& field_path = {},
                      const Landmarks& landmarks = {});
  /// Sets the transform of the active layer from a file.
  void load_transform(const QString& path);
  /// Writes the affine transform of the active layer.
  void save_transform(const QString& path);

 private:
  const LayerItem* active() const;
  void ask_registration();
  void connect_display();
  void refresh();
  void set_transform(ItemId layer, const LayerTransform& transform, const QString& note);

  Workbench& workbench_;
  BackgroundJob& job_;
  FileActions& files_;
  ActionTable& actions_;
  QWidget& window_;
};

}  // namespace simplexseg
