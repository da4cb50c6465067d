// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QDialog>
#include <QString>
#include <optional>
#include <vector>

#include "remote/network_calls.h"
#include "session/scene.h"

class QComboBox;
class QDoubleSpinBox;
class QLabel;
class QPushButton;
class QSpinBox;

namespace simplexseg {

class BackgroundJob;
class ConnectionFields;
class TaskLine;
class Workbench;

/// Starts a segmentation from the mask of a network on a server (docs/networks.md). Nothing is sent before *Connect* is
/// pressed, and no image before *Send*.
class NetworkDialog : public QDialog {
  Q_OBJECT
 public:
  /// `mesh`: segmentation to start; `job`: see TaskLine.
  NetworkDialog(Workbench& workbench, ItemId mesh, BackgroundJob& job, QWidget* parent);

  const TaskLine& task() const { return *task_; }
  /// Cancels the running call; closes the dialog if there is none.
  void reject() override;

 private:
  /// Server that has responded, and what is sent to it.
  struct Connected {
    NetworkServer server;
    NetworkInfo info;
    NetworkPrompts prompts;
  };
  void build_fields();
  void read_servers();
  /// Server as entered. Throws Error for an unknown name and invalid settings.
  NetworkServer entered_server() const;
  /// Shows the settings of the entered server if it is one of the list.
  void show_settings();
  /// Forgets the server that has responded, after a change of its settings.
  void forget();
  void refresh();
  QString statement() const;

  void connect_to_server();
  void show_connected(const NetworkServer& server, const NetworkInfo& info);
  void send();
  void take(const MeshStart& start);

  Workbench& workbench_;
  const ItemId mesh_;
  std::vector<NetworkServer> servers_;
  std::optional<Connected> connected_;
  QWidget* fields_;
  QComboBox *server_, *network_;
  ConnectionFields* connection_;
  QSpinBox* timeout_;
  QDoubleSpinBox* error_;
  QLabel* statement_;
  TaskLine* task_;
  QPushButton *connect_, *send_;
};

}  // namespace simplexseg
