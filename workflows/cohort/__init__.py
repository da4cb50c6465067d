# SPDX-License-Identifier: Apache-2.0
"""Runs simplexseg-cli on the volumes of a table and writes one page with the results (docs/cohort.md)."""
