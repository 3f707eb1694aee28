def show(page, old, new):
    pass
