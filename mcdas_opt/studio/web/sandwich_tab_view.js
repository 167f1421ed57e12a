// Vue's door to the sandwich tab.
export default {
  template: `<div class="mcdas mcdas-studio"></div>`,
  props: { upload: Object },
  mounted() {
    document.querySelectorAll(".mcdas-loading").forEach((sign) => sign.remove());
    const { look, sandwich } = window.mcdas.setup;
    this.view = new window.mcdas.SandwichTab(this.$el, look, { ...sandwich, upload: this.upload }, (name, payload) => this.$emit(name, payload));
    this.$emit("ready", this.view.first);
  },
  methods: {
    hear(part) { this.view.hear(part); },
  },
};
