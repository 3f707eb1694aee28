def show(page, results):
    pass
