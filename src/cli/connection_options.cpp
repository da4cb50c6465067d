// SPDX-License-Identifier: Apache-2.0
#include "cli/connection_options.h"

namespace simplexseg {

void add_connection_options(const Subcommand& sub, ConnectionOptions& options, int default_s) {
  sub.add_option("--ca-file", options.ca_file, "File of trusted certificates (PEM), instead of those of the system");
  sub.add_option("--credentials-variable", options.credentials_variable,
                 "Environment variable that contains USER:PASSWORD or \"bearer TOKEN\" for the server");
  sub.add_option("--credentials-file", options.credentials_file,
                 "File of mode 600 that contains USER:PASSWORD or \"bearer TOKEN\" for the server");
  sub.add_option("--timeout", options.timeout_s,
                 "Seconds to wait for data before the connection is closed; default: " + std::to_string(default_s))
      .within(1, 3600);
}

}  // namespace simplexseg
