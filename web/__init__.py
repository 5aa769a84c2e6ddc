# The pages: HTML, CSS, ES modules, texts; a package (gazeweb) once installed.
