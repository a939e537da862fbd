"""The chapters of docs/report.md that need pictures or numbers; each has run(studio)."""
