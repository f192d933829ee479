"""The studio: a page in the browser whose controls answer at once.

The server is thin: it reads what the page asks for through the checks of the command line, calls the analyses of the
register and what they are made of, and sends numbers. The page, in ``static``, draws them.
"""
