# SPDX-License-Identifier: Apache-2.0
"""Runs simplexseg-cli on the volumes listed in a table and writes one HTML page with the results (docs/cohort.md)."""
