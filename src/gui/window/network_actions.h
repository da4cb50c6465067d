// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QObject>
#include <QPointer>

class QWidget;

namespace simplexseg {

class ActionTable;
class BackgroundJob;
class NetworkDialog;
class Workbench;

/// Action that starts the active segmentation from a network on a server, with its dialog.
class NetworkActions : public QObject {
  Q_OBJECT
 public:
  NetworkActions(Workbench& workbench, ActionTable& actions, QWidget& window);
  ~NetworkActions() override;

 private:
  void refresh();
  void ask();

  Workbench& workbench_;
  ActionTable& actions_;
  QWidget& window_;
  BackgroundJob* job_;              ///< outlives the dialog
  QPointer<NetworkDialog> dialog_;  ///< null unless open
};

}  // namespace simplexseg
