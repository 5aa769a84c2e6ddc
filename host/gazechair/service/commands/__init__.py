"""Arguments of the service commands; what does the work is imported only when one runs."""
